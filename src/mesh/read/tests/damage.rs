//! Random damage to good files.

use super::abaqus::INP;
use super::formats::{MEDIT, VTK};
use super::*;
use proptest::prelude::*;

const TEXTS: [&str; 6] = [MSH2, MSH4, GID, INP, MEDIT, VTK];

/// One way to spoil a text.
#[derive(Debug, Clone)]
pub(super) enum Damage {
    Truncate(prop::sample::Index),
    DeleteLine(prop::sample::Index),
    RepeatLine(prop::sample::Index),
    DeleteToken(prop::sample::Index),
    ReplaceToken(prop::sample::Index, &'static str),
    SwapTokens(prop::sample::Index, prop::sample::Index),
}

const ODD_TOKENS: [&str; 18] = [
    "-1",
    "0",
    "1e400",
    "nan",
    "4294967295",
    "99999999999999999999",
    "$Nodes",
    "$EndElements",
    "\"",
    "x",
    "1,5",
    "4",
    "11",
    "é\u{0}",
    "*ELSET,ELSET=Base,GENERATE",
    "Tetrahedra",
    "CELL_DATA",
    ",",
];

pub(super) fn damage() -> impl Strategy<Value = Damage> {
    let place = any::<prop::sample::Index>;
    prop_oneof![
        place().prop_map(Damage::Truncate),
        place().prop_map(Damage::DeleteLine),
        place().prop_map(Damage::RepeatLine),
        place().prop_map(Damage::DeleteToken),
        (place(), prop::sample::select(&ODD_TOKENS[..])).prop_map(|(i, t)| Damage::ReplaceToken(i, t)),
        (place(), place()).prop_map(|(i, j)| Damage::SwapTokens(i, j)),
    ]
}

pub(super) fn apply(text: &str, damage: &Damage) -> String {
    let mut lines: Vec<&str> = text.split_inclusive('\n').collect();
    // Tokens alternate with the white space after them.
    let mut tokens: Vec<&str> = text.split_inclusive([' ', '\n']).collect();
    if lines.is_empty() {
        return String::new();
    }
    match damage {
        Damage::Truncate(i) => return text.chars().take(i.index(text.len())).collect(),
        Damage::DeleteLine(i) => drop(lines.remove(i.index(lines.len()))),
        Damage::RepeatLine(i) => lines.insert(i.index(lines.len()), lines[i.index(lines.len())]),
        Damage::DeleteToken(i) => {
            tokens.remove(i.index(tokens.len()));
            return tokens.concat();
        }
        Damage::ReplaceToken(i, new) => {
            let i = i.index(tokens.len());
            let replaced = format!("{new}{}", if tokens[i].ends_with('\n') { "\n" } else { " " });
            tokens[i] = &replaced;
            return tokens.concat();
        }
        Damage::SwapTokens(i, j) => {
            let (i, j) = (i.index(tokens.len()), j.index(tokens.len()));
            tokens.swap(i, j);
            return tokens.concat();
        }
    }
    lines.concat()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(2000))]

    /// Whatever is done to a file, reading it gives a valid mesh or an error.
    #[test]
    fn damaged_files_never_panic(which in 0..TEXTS.len(), damages in prop::collection::vec(damage(), 1..4)) {
        let text = damages.iter().fold(TEXTS[which].to_owned(), |text, d| apply(&text, d));
        if let Ok(file) = parse_text(&text) {
            prop_assert!(TetMesh::new(file.mesh.into_parts()).is_ok());
        }
    }

    #[test]
    fn random_bytes_after_a_header_never_panic(which in 0..TEXTS.len(), bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        let head: String = TEXTS[which].lines().take(12).map(|l| format!("{l}\n")).collect();
        let _ = parse_bytes(&[head.as_bytes(), &bytes].concat());
    }
}

/// Cuts every file of `tests/meshes/` short and flips its bytes, one in turn. Whatever is left is a valid mesh or an
/// error.
#[test]
fn no_damage_to_a_file_of_any_format_panics() {
    let folder = Path::new(env!("CARGO_MANIFEST_DIR")).join("tests/meshes");
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let bytes = std::fs::read(&path).unwrap();
        let check = |bytes: &[u8]| match parse(&path, bytes, bytes.len() as u64, Edges::Straight) {
            Ok(file) => drop(TetMesh::new(file.mesh.into_parts()).unwrap()),
            Err(MeshError::Inconsistent(message)) => panic!("{}: {message}", path.display()),
            Err(_) => {}
        };
        for i in (0..bytes.len()).step_by(3) {
            if i % 7 == 0 {
                check(&bytes[..i]);
            }
            let mut flipped = bytes.clone();
            flipped[i] ^= [0x01, 0x80, 0x10, 0xff][i % 4];
            check(&flipped);
        }
    }
}

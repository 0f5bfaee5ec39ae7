//! A mesh of a few tetrahedra as words, so that each can be spoilt, written in every format; and the program, run on files.

use assert_cmd::Command;
use miette::Diagnostic as _;
use std::path::Path;
use subsolid::Error;
use subsolid::mesh::read::{MeshFile, read};

/// The formats that are texts.
#[derive(Debug, Clone, Copy, PartialEq, Eq)]
pub enum Format {
    Msh2,
    Msh4,
    Gid,
    Inp,
    Medit,
    Vtk,
    Vtu,
}

use Format::{Gid, Inp, Medit, Msh2, Msh4, Vtk, Vtu};

pub const ALL: [Format; 7] = [Msh2, Msh4, Gid, Inp, Medit, Vtk, Vtu];

/// Those that say how many nodes and elements follow.
pub const COUNTED: [Format; 5] = [Msh2, Msh4, Medit, Vtk, Vtu];

/// Those that give nodes and elements ids.
pub const WITH_IDS: [Format; 4] = [Msh2, Msh4, Gid, Inp];

/// Words of a mesh. Nodes of tetrahedra are ids; formats without them count from 1 here, and from their first number in the file.
#[derive(Clone)]
pub struct Rough {
    pub nodes: Vec<[String; 4]>,
    pub tets: Vec<[String; 5]>,
    /// What the file says of their numbers, if not the truth.
    pub counts: [Option<String>; 2],
}

/// Rows of words, in a line each.
pub fn rows<const N: usize>(text: &str) -> Vec<[String; N]> {
    let row = |line: &str| line.split_whitespace().map(str::to_owned).collect::<Vec<_>>().try_into().unwrap();
    text.lines().map(row).collect()
}

impl Rough {
    pub fn new(nodes: &str, tets: &str) -> Self {
        Self { nodes: rows(nodes), tets: rows(tets), counts: [None, None] }
    }

    /// Two tetrahedra, 1 above and 2 below their face of nodes 1, 2 and 3.
    pub fn pair() -> Self {
        Self::new("1 0 0 0\n2 1 0 0\n3 0 1 0\n4 0 0 1\n5 0 0 -1", "1 1 2 3 4\n2 1 3 2 5")
    }

    pub fn change(&self, change: impl Fn(&mut Self)) -> Self {
        let mut other = self.clone();
        change(&mut other);
        other
    }

    fn count(&self, which: usize) -> String {
        self.counts[which].clone().unwrap_or_else(|| [self.nodes.len(), self.tets.len()][which].to_string())
    }

    pub fn text(&self, format: Format) -> String {
        let points = |from: usize, by: &str| lines(self.nodes.iter().map(|n| n[from..].join(by)));
        let cells = |from: usize, by: &str| lines(self.tets.iter().map(|t| t[from..].join(by)));
        let [nodes, tets] = [0, 1].map(|which| self.count(which));
        match format {
            Msh2 => format!(
                "$MeshFormat\n2.2 0 8\n$EndMeshFormat\n$Nodes\n{nodes}\n{}$EndNodes\n$Elements\n{tets}\n{}$EndElements\n",
                points(0, " "),
                lines(self.tets.iter().map(|t| format!("{} 4 2 1 1 {}", t[0], t[1..].join(" "))))
            ),
            Msh4 => format!(
                "$MeshFormat\n4.1 0 8\n$EndMeshFormat\n$Nodes\n1 {nodes} 1 5\n3 1 0 {nodes}\n{}{}$EndNodes\n$Elements\n1 {tets} \
                 1 2\n3 1 4 {tets}\n{}$EndElements\n",
                lines(self.nodes.iter().map(|n| n[0].clone())),
                points(1, " "),
                cells(0, " ")
            ),
            Gid => format!(
                "MESH dimension 3 ElemType Tetrahedra Nnode 4\nCoordinates\n{}End Coordinates\nElements\n{}End Elements\n",
                points(0, " "),
                cells(0, " ")
            ),
            Inp => format!("*NODE\n{}*ELEMENT, TYPE=C3D4\n{}", points(0, ", "), cells(0, ", ")),
            Medit => format!(
                "MeshVersionFormatted 2\nDimension 3\nVertices\n{nodes}\n{}Tetrahedra\n{tets}\n{}End\n",
                lines(self.nodes.iter().map(|n| n[1..].join(" ") + " 0")),
                lines(self.tets.iter().map(|t| t[1..].join(" ") + " 1"))
            ),
            Vtk => format!(
                "# vtk DataFile Version 3.0\nmesh\nASCII\nDATASET UNSTRUCTURED_GRID\nPOINTS {nodes} double\n{}CELLS {tets} \
                 {}\n{}CELL_TYPES {tets}\n{}",
                points(1, " "),
                5 * self.tets.len(),
                lines(self.tets.iter().map(|t| format!("4 {}", from_zero(t)))),
                lines(self.tets.iter().map(|_| "10".to_owned()))
            ),
            Vtu => format!(
                "<VTKFile type=\"UnstructuredGrid\" version=\"1.0\"><UnstructuredGrid>\n<Piece NumberOfPoints=\"{nodes}\" \
                 NumberOfCells=\"{tets}\"><Points>\n<DataArray type=\"Float64\" NumberOfComponents=\"3\" format=\"ascii\">\n{}\
                 </DataArray></Points>\n<Cells>\n<DataArray type=\"Int64\" Name=\"connectivity\" format=\"ascii\">\n{}</DataArray>\n\
                 <DataArray type=\"Int64\" Name=\"offsets\" format=\"ascii\">\n{}</DataArray>\n<DataArray type=\"UInt8\" \
                 Name=\"types\" format=\"ascii\">\n{}</DataArray>\n</Cells></Piece></UnstructuredGrid></VTKFile>\n",
                points(1, " "),
                lines(self.tets.iter().map(from_zero)),
                lines((1..=self.tets.len()).map(|i| (4 * i).to_string())),
                lines(self.tets.iter().map(|_| "10".to_owned()))
            ),
        }
    }
}

/// The nodes of a tetrahedron counted from zero; what is no number stays.
fn from_zero(tet: &[String; 5]) -> String {
    let less = |word: &String| word.parse::<i64>().map_or_else(|_| word.clone(), |n| (n - 1).to_string());
    tet[1..].iter().map(less).collect::<Vec<_>>().join(" ")
}

fn lines(lines: impl Iterator<Item = String>) -> String {
    lines.map(|line| line + "\n").collect()
}

/// Reads a mesh file of these bytes.
pub fn read_bytes(bytes: &[u8]) -> Result<MeshFile, Error> {
    let folder = tempfile::tempdir().unwrap();
    let path = folder.path().join("part.mesh");
    std::fs::write(&path, bytes).unwrap();
    read(&path).map_err(Error::from)
}

/// What is said of a mesh file that is refused: the message and the help. The exit code is that of bad meshes.
pub fn refused(bytes: &[u8]) -> String {
    let error = read_bytes(bytes).unwrap_err();
    assert_eq!(error.exit_code(), 4, "{error}");
    format!("{error}\n{}", error.help().map(|help| help.to_string()).unwrap_or_default())
}

/// Asserts that the mesh is refused in each of these formats, and that the message has these words.
pub fn assert_refused(rough: &Rough, formats: &[Format], words: &[&str]) {
    for &format in formats {
        let said = refused(rough.text(format).as_bytes());
        for word in words {
            assert!(said.contains(word), "{format:?}: {word:?} is not in {said}");
        }
    }
}

/// Asserts that the mesh is accepted in each of these formats, and what its notes say.
pub fn assert_noted(rough: &Rough, formats: &[Format], words: &[&str]) {
    for &format in formats {
        let notes = read_bytes(rough.text(format).as_bytes()).unwrap_or_else(|e| panic!("{format:?}: {e}")).notes;
        for word in words {
            assert!(notes.iter().any(|note| note.contains(word)), "{format:?}: {word:?} is not in {notes:?}");
        }
    }
}

/// Runs the program in a folder; gives its exit code, standard output and standard error, these with words one blank apart.
pub fn subsolid(folder: &Path, arguments: &[&str]) -> (Option<i32>, String, String) {
    let mut command = Command::cargo_bin("subsolid").unwrap();
    command.args(arguments).current_dir(folder).env_remove("SUBSOLID_DATA").env("NO_COLOR", "1");
    let output = command.output().unwrap();
    let text = |bytes: Vec<u8>| {
        let text = String::from_utf8(bytes).unwrap();
        assert!(!text.contains("panicked"), "{arguments:?}: {text}");
        // Messages are broken into lines with a bar before each.
        text.split_whitespace().filter(|w| *w != "│").collect::<Vec<_>>().join(" ")
    };
    (output.status.code(), text(output.stdout), text(output.stderr))
}

/// The names of what a folder holds, sorted.
pub fn names(folder: &Path) -> Vec<String> {
    let entries = std::fs::read_dir(folder).unwrap();
    let mut names: Vec<String> = entries.map(|e| e.unwrap().file_name().into_string().unwrap()).collect();
    names.sort_unstable();
    names
}

/// A folder with these files.
pub fn folder(files: &[(&str, &str)]) -> tempfile::TempDir {
    let folder = tempfile::tempdir().unwrap();
    files.iter().for_each(|(name, text)| std::fs::write(folder.path().join(name), text).unwrap());
    folder
}

/// Asserts that a command fails with a code and these words on standard error, and leaves the folder as it was.
pub fn assert_fails(folder: &Path, arguments: &[&str], code: i32, words: &[&str]) {
    let before = names(folder);
    let (status, _, stderr) = subsolid(folder, arguments);
    assert_eq!(status, Some(code), "{arguments:?}: {stderr}");
    for word in words {
        assert!(stderr.contains(word), "{arguments:?}: {word:?} is not in {stderr}");
    }
    assert_eq!(names(folder), before, "{arguments:?}");
}

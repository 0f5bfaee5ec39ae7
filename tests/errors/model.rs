//! Class 34, and what of a model needs a whole run to be told; the other classes of models are in `tests/resolve.rs`, `tests/supports.rs`
//! and `tests/run.rs`.

use super::rough::{assert_fails, folder};

#[test]
fn class_34_a_model_without_supports_names_the_six_free_motions() {
    let scenario = "[mesh.box]\nsize = [2, 1, 1]\ncells = [2, 1, 1]\n[materials.a]\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n\
                    [loads.a]\ngroup = \"x-max\"\nforce = [0, 0, -1]\n";
    let folder = folder(&[("case.toml", scenario)]);
    let words = ["free to move along x, y and z and to turn about x, y and z", "six free motions", "[supports.clamp]"];
    for element in ["tet10", "hex20"] {
        let set = format!("analysis.element={element}");
        for command in ["run", "check"] {
            assert_fails(folder.path(), &[command, "case.toml", "--set", &set], 5, &words);
        }
    }
}

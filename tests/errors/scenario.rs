//! Classes 49 and 50, and 43: values of a scenario out of their range.

use super::rough::{assert_fails, folder};

const SCENARIO: &str = "[mesh.box]\nsize = [2, 1, 1]\ncells = [2, 1, 1]\n[materials.a]\nyoungs_modulus = 1.0\npoissons_ratio = 0.3\n\
                        [supports.a]\ngroup = \"x-min\"\nfix = [\"x\", \"y\", \"z\"]\n[loads.a]\ngroup = \"x-max\"\n\
                        force = [0, 0, -1]\n";

/// Asserts that a value of a key is refused, with these words, by every command that reads scenarios.
fn assert_refused(key: &str, values: &[&str], words: &[&str]) {
    let folder = folder(&[("case.toml", SCENARIO)]);
    for value in values {
        let set = format!("{key}={value}");
        for command in ["run", "check", "compare"] {
            let place = format!("--set {set}: `{key}`");
            assert_fails(folder.path(), &[command, "case.toml", "--set", &set], 3, &[&[&*place], words].concat());
        }
    }
}

#[test]
fn class_43_a_modulus_that_is_not_positive_is_refused() {
    assert_refused("materials.a.youngs_modulus", &["0", "-210e9", "nan", "inf"], &["positive"]);
    assert_refused("materials.a.density", &["-1", "nan"], &[]);
}

#[test]
fn class_49_negative_or_absurd_levels_are_refused() {
    assert_refused("refine.steps", &["-1", "21", "1000000", "99999999999"], &["0 to 20"]);
    assert_refused("adapt.grow", &["-1"], &[]);
}

#[test]
fn class_50_a_share_outside_0_to_1_is_refused() {
    let words = ["above 0 and at most 1"];
    assert_refused("adapt.marking.doerfler", &["0", "-0.5", "1.01", "nan"], &words);
    assert_refused("adapt.marking.fraction", &["0", "2"], &words);
}

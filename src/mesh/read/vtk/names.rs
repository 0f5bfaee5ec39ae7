//! Names of regions and groups in the field data of our own files.

use super::super::raw::Raw;

/// Arrays of the field data.
#[derive(Debug, Default)]
pub(super) struct Names {
    pub(super) regions: Vec<f64>,
    pub(super) groups: Vec<f64>,
    /// Rows of a group's number and three points.
    pub(super) faces: Vec<f64>,
    /// Rows of a group's number and four points.
    pub(super) quads: Vec<f64>,
}

impl Names {
    /// Where an array of that name goes, if it is one of ours.
    pub(super) fn slot(&mut self, name: &str) -> Option<&mut Vec<f64>> {
        match name {
            "region_names" => Some(&mut self.regions),
            "group_names" => Some(&mut self.groups),
            "group_faces" => Some(&mut self.faces),
            "group_quads" => Some(&mut self.quads),
            _ => None,
        }
    }

    /// Names the regions, and adds the faces of the groups. Other programs may have cut the mesh or joined it with another:
    /// faces that are no longer there count as triangles inside, which are passed over.
    pub(super) fn apply(&self, raw: &mut Raw, place: u64) {
        raw.region_names.extend((0..).zip(strings(&self.regions)));
        let groups = strings(&self.groups);
        let points = raw.nodes.positions.len() as f64;
        let sound = |row: &[f64]| {
            row[0] >= 0.0 && row[0] < groups.len() as f64 && row[1..].iter().all(|v| (0.0..points).contains(v))
        };
        let fit = |rows: &[f64], width: usize| rows.len().is_multiple_of(width) && rows.chunks_exact(width).all(sound);
        if !fit(&self.faces, 4) || !fit(&self.quads, 5) {
            raw.notes.push("the groups of the file do not fit its mesh and are ignored.".to_owned());
            return;
        }
        let first = raw.element_count() as u32;
        for (i, row) in (0..).zip(self.faces.chunks_exact(4)) {
            let [a, b, c] = [row[1], row[2], row[3]].map(|v| v as u32);
            raw.triangle(first + i, [a, b, c], [row[0] as i32 + 1, 0], place);
        }
        let first = raw.element_count() as u32;
        for (i, row) in (0..).zip(self.quads.chunks_exact(5)) {
            let [a, b, c, d] = [row[1], row[2], row[3], row[4]].map(|v| v as u32);
            raw.quad(first + i, [a, b, c, d], [row[0] as i32 + 1, 0], place);
        }
        raw.group_names.extend((1..).zip(groups));
    }
}

/// Strings of bytes, each ended by a zero.
fn strings(codes: &[f64]) -> Vec<String> {
    let bytes: Vec<u8> = codes.iter().map(|&code| code as u8).collect();
    let mut strings: Vec<String> =
        bytes.split(|&byte| byte == 0).map(|text| String::from_utf8_lossy(text).into_owned()).collect();
    // What follows the last zero.
    strings.pop();
    strings
}

#[cfg(test)]
mod tests {
    use super::*;
    use glam::DVec3;

    /// The lists of a file after names were applied to four points.
    fn applied(groups: &[u8], faces: &[f64]) -> Raw {
        let mut raw = Raw::default();
        (0..4).for_each(|id| raw.nodes.push(id, DVec3::ZERO, 0));
        let groups = groups.iter().map(|&byte| f64::from(byte)).collect();
        let names =
            Names { regions: vec![98.0, 111.0, 110.0, 101.0, 0.0], groups, faces: faces.to_vec(), quads: Vec::new() };
        names.apply(&mut raw, 7);
        raw
    }

    #[test]
    fn names_are_those_between_the_zeros() {
        let raw = applied(b"top\0\xc3\xa4\0", &[0.0, 1.0, 2.0, 3.0, 1.0, 0.0, 1.0, 2.0]);
        assert_eq!(raw.region_names[&0], "bone");
        assert_eq!((raw.group_names[&1].as_str(), raw.group_names[&2].as_str()), ("top", "\u{e4}"));
        assert_eq!(raw.triangles.nodes, [[1, 2, 3], [0, 1, 2]]);
        assert_eq!(raw.triangles.tags.iter().collect::<Vec<_>>(), [1, 2]);
    }

    #[test]
    fn groups_of_another_mesh_are_passed_over_with_a_note() {
        for faces in [&[0.0, 1.0, 2.0][..], &[0.0, 1.0, 2.0, 4.0], &[1.0, 0.0, 1.0, 2.0], &[0.0, 0.0, -1.0, f64::NAN]] {
            let raw = applied(b"top\0", faces);
            assert!(raw.triangles.nodes.is_empty() && raw.group_names.is_empty(), "{faces:?}");
            assert_eq!(raw.notes.len(), 1);
        }
    }
}

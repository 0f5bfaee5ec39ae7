//! A writer of binary Gmsh files for tests.

use subsolid::mesh::TetMesh;

/// A mesh in Gmsh's binary format 4.1, in either order of bytes.
pub fn binary_msh(mesh: &TetMesh, big_endian: bool) -> Vec<u8> {
    let mut out = b"$MeshFormat\n4.1 1 8\n".to_vec();
    let int = |out: &mut Vec<u8>, x: i32| out.extend(if big_endian { x.to_be_bytes() } else { x.to_le_bytes() });
    let size = |out: &mut Vec<u8>, x: usize| {
        out.extend(if big_endian { (x as u64).to_be_bytes() } else { (x as u64).to_le_bytes() });
    };
    int(&mut out, 1);
    out.extend(b"\n$EndMeshFormat\n$Nodes\n");
    let (nodes, cells) = (mesh.points().len(), mesh.tets().len());
    [1, nodes, 1, nodes].into_iter().for_each(|x| size(&mut out, x));
    [3, 1, 0].into_iter().for_each(|x| int(&mut out, x));
    size(&mut out, nodes);
    (1..=nodes).for_each(|id| size(&mut out, id));
    for x in mesh.points().iter().flat_map(|p| p.to_array()) {
        out.extend(if big_endian { x.to_be_bytes() } else { x.to_le_bytes() });
    }
    out.extend(b"\n$EndNodes\n$Elements\n");
    [1, cells, 1, cells].into_iter().for_each(|x| size(&mut out, x));
    [3, 1, 4].into_iter().for_each(|x| int(&mut out, x));
    size(&mut out, cells);
    for (id, tet) in (1..).zip(mesh.tets()) {
        size(&mut out, id);
        tet.iter().for_each(|&v| size(&mut out, v as usize + 1));
    }
    out.extend(b"\n$EndElements\n");
    out
}

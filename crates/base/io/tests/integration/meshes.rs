//! Mesh files: exact round trips, dialects, damage and nonsense.

use crate::common::cases;
use proptest::prelude::*;
use protomer_io::mesh::{MeshFormat, ply, read_mesh, write_mesh};
use protomer_kernel::setting::Choices;
use protomer_kernel::{TriangleMesh, Vec3};

/// Each format with the name of a file in it.
fn formats() -> impl Iterator<Item = (MeshFormat, String)> {
    let with_name = |format: &MeshFormat| (*format, format!("m.{}", format.name()));
    MeshFormat::ALL.iter().map(with_name)
}

fn tetrahedron() -> TriangleMesh {
    let vertices = [
        [0.0, 0.0, 0.0],
        [1.5, 0.0, 0.0],
        [0.0, 2.5, 0.0],
        [0.0, 0.0, -1e-3],
    ]
    .map(Vec3::from)
    .to_vec();
    TriangleMesh {
        vertices,
        triangles: vec![[0, 1, 2], [0, 3, 1], [0, 2, 3], [1, 3, 2]],
    }
}

fn any_mesh() -> impl Strategy<Value = TriangleMesh> {
    let coordinate = prop_oneof![-1e3..1e3f64, prop::num::f64::NORMAL.prop_map(|x| x % 1e30)];
    let vertices = prop::collection::vec(
        [coordinate.clone(), coordinate.clone(), coordinate].prop_map(Vec3::from),
        3..40,
    );
    vertices.prop_flat_map(|vertices| {
        let count = vertices.len() as u32;
        prop::collection::vec([0..count, 0..count, 0..count], 1..60).prop_map(move |triangles| {
            TriangleMesh {
                vertices: vertices.clone(),
                triangles,
            }
        })
    })
}

/// The corners of each triangle, which is all that some formats keep.
fn soup(mesh: &TriangleMesh) -> Vec<[Vec3; 3]> {
    (0..mesh.triangles.len())
        .map(|triangle| mesh.corners(triangle))
        .collect()
}

proptest! {
    #![proptest_config(ProptestConfig::with_cases(cases(64)))]

    #[test]
    fn meshes_read_back_exactly(mesh in any_mesh()) {
        for (format, name) in formats().filter(|(format, _)| format.is_exact()) {
            prop_assert_eq!(&read_mesh(&name, &write_mesh(format, &mesh)).unwrap(), &mesh, "{}", name);
        }
        prop_assert_eq!(&read_mesh("a.ply.gz", ply::write_ply_ascii(&mesh).as_bytes()).unwrap(), &mesh);
    }

    #[test]
    fn other_formats_keep_the_triangles_to_single_precision(mesh in any_mesh()) {
        let rounded = mesh.map_vertices(|v| v.map(|x| f64::from(x as f32)));
        let solid = |t: &[Vec3; 3]| t[0] != t[1] && t[1] != t[2] && t[2] != t[0];
        let expected: Vec<_> = soup(&rounded).into_iter().filter(solid).collect();
        for (format, name) in formats().filter(|(format, _)| !format.is_exact()) {
            match read_mesh(&name, &write_mesh(format, &mesh)) {
                Ok(back) => prop_assert_eq!(soup(&back), &expected[..], "{}", name),
                Err(error) => prop_assert!(expected.is_empty(), "{}", error),
            }
        }
    }

    #[test]
    fn no_mutation_of_a_valid_file_panics(
        changes in prop::collection::vec((any::<prop::sample::Index>(), any::<u8>()), 0..6),
        cut in prop::option::of(any::<prop::sample::Index>()),
    ) {
        for (name, mut bytes) in valid_files() {
            for (index, value) in &changes {
                let place = index.index(bytes.len());
                bytes[place] = *value;
            }
            if let Some(cut) = cut {
                bytes.truncate(cut.index(bytes.len()));
            }
            if let Ok(mesh) = read_mesh(&name, &bytes) {
                let count = mesh.vertices.len() as u32;
                prop_assert!(mesh.vertices.iter().all(|v| v.iter().all(|x| x.is_finite())));
                prop_assert!(mesh.triangles.iter().flatten().all(|vertex| *vertex < count));
            }
        }
    }

    #[test]
    fn no_junk_panics(bytes in prop::collection::vec(any::<u8>(), 0..300)) {
        for (_, name) in formats() {
            let _ = read_mesh(&name, &bytes);
        }
    }
}

fn valid_files() -> Vec<(String, Vec<u8>)> {
    let mesh = tetrahedron();
    let mut files: Vec<_> = formats()
        .map(|(format, name)| (name, write_mesh(format, &mesh)))
        .collect();
    files.push(("m.ply".into(), ply::write_ply_ascii(&mesh).into_bytes()));
    files.push(("m.stl".into(), ASCII_STL.as_bytes().to_vec()));
    files.push((
        "m.ply".into(),
        BIG_ENDIAN_HEADER
            .as_bytes()
            .iter()
            .copied()
            .chain(big_endian_body())
            .collect(),
    ));
    files
}

const ASCII_STL: &str = "solid t\n facet normal 0 0 0\n  outer loop\n   vertex 0 0 0\n   vertex 1e0 0 0\n   vertex 0 1 0\n  \
     endloop\n endfacet\n facet normal 0 0 0\n outer loop\n vertex -0 0 0\n vertex 0 1 0\n vertex 0 0 1\n endloop\n \
     endfacet\nendsolid t\n";

const BIG_ENDIAN_HEADER: &str = "ply\r\nformat binary_big_endian 1.0\r\nobj_info made by hand\r\nelement vertex 4\r\n\
     property float x\r\nproperty float y\r\nproperty float z\r\nproperty uchar red\r\nelement face 1\r\n\
     property uchar flags\r\nproperty list ushort int vertex_index\r\nend_header\r\n";

fn big_endian_body() -> Vec<u8> {
    let mut body = Vec::new();
    for point in [
        [0.0f32, 0.0, 0.0],
        [1.0, 0.0, 0.0],
        [1.0, 1.0, 0.0],
        [0.0, 1.0, 0.0],
    ] {
        point.iter().for_each(|x| body.extend(x.to_be_bytes()));
        body.push(255);
    }
    body.push(7);
    body.extend(4u16.to_be_bytes());
    (0..4).for_each(|i: i32| body.extend(i.to_be_bytes()));
    body
}

#[test]
fn big_endian_ply_with_other_properties_is_read() {
    let bytes: Vec<u8> = BIG_ENDIAN_HEADER.bytes().chain(big_endian_body()).collect();
    let mesh = read_mesh("m.ply", &bytes).unwrap();
    assert_eq!(mesh.vertices[2], Vec3::new(1.0, 1.0, 0.0));
    assert_eq!(mesh.triangles.len(), 2);
    assert!((mesh.area_angstrom2() - 1.0).abs() < 1e-12);
}

#[test]
fn ascii_stl_is_welded() {
    let mesh = read_mesh("m.stl", ASCII_STL.as_bytes()).unwrap();
    assert_eq!((mesh.vertices.len(), mesh.triangles.len()), (4, 2));
}

#[test]
fn a_closed_mesh_stays_closed_through_stl() {
    let mesh = tetrahedron();
    let expected = mesh.topology();
    let back = read_mesh("m.stl", &write_mesh(MeshFormat::Stl, &mesh)).unwrap();
    assert_eq!(back.topology(), expected);
}

#[test]
fn obj_dialects_are_read() {
    let text = "# cube face\nmtllib x\nv 0 0 0 1.0\nv 1 0 0\nv 1 1 0\nvn 0 0 1\ng a\nv 0 1 0\nf -4//1 2/3/1 \\\n 3/1 4\n";
    let mesh = read_mesh("x.OBJ", text.as_bytes()).unwrap();
    assert_eq!(mesh.triangles.len(), 2);
    assert!((mesh.area_angstrom2() - 1.0).abs() < 1e-12);
}

#[test]
fn off_dialects_are_read() {
    for text in [
        "OFF 3 1 0\n0 0 0\n1 0 0\n0 1 0\n3 0 1 2\n",
        "# c\nCOFF\n\n3 1 3\n0 0 0 1 1 1 1\n1 0 0 1 1 1 1\n0 1 0 0 0 0 1\n3 0 1 2 255 0 0\n",
    ] {
        assert_eq!(
            read_mesh("x.off", text.as_bytes()).unwrap().triangles,
            [[0, 1, 2]]
        );
    }
}

#[test]
fn errors_say_where_and_what() {
    let ply = |counts: &str, body: &str| {
        format!(
            "ply\nformat ascii 1.0\nelement vertex {counts}\nproperty float x\nproperty float y\nproperty float z\n\
             element face 1\nproperty list uchar int vertex_indices\nend_header\n{body}"
        )
    };
    let cases: Vec<(&str, Vec<u8>, &str)> = vec![
        (
            "m.xyz",
            vec![],
            "m.xyz: the extension does not name a mesh format",
        ),
        ("m.ply", vec![], "m.ply: the header has no end"),
        ("m.obj", vec![], "m.obj: the file is empty"),
        ("m.obj", b"v 1 2 3\0".to_vec(), "binary data, not text"),
        (
            "m.obj",
            b"v 1 2\n".to_vec(),
            "m.obj:1: z of a vertex is missing",
        ),
        (
            "m.obj",
            b"v 1 2 nan\n".to_vec(),
            "m.obj:1: z of a vertex is \"nan\"",
        ),
        (
            "m.obj",
            b"v 0 0 0\nf 1 2 3\n".to_vec(),
            "m.obj:2: a face refers to vertex 1 (counted from zero), but there are 1",
        ),
        (
            "m.obj",
            b"v 0 \\\n0 \\\n0\nv 1 0 0\nf 1 2 \\\r\n3\n".to_vec(),
            "m.obj:5: a face refers to vertex 2 (counted from zero), but there are 2",
        ),
        (
            "m.obj",
            b"v 0 0 0\nf 1 1 0\n".to_vec(),
            "m.obj:2: a face refers to vertex 0",
        ),
        (
            "m.obj",
            b"v 0 0 0\nf 1 1\n".to_vec(),
            "m.obj:2: a face has 2 corners",
        ),
        (
            "m.obj",
            b"v 0 0 0\n".to_vec(),
            "m.obj: the file holds no faces",
        ),
        (
            "m.off",
            b"PFF\n".to_vec(),
            "m.off:1: the file does not begin with OFF",
        ),
        (
            "m.off",
            b"OFF\n9000000000000000000 1 0\n0 0 0\n".to_vec(),
            "m.off: the file ends before all its faces",
        ),
        (
            "m.off",
            b"OFF\n3 1 0\n0 0 0\n1 0 0\n0 1 0\n4 0 1 2\n".to_vec(),
            "m.off:6: a face has 3 of its 4 corners",
        ),
        (
            "m.ply",
            ply("18446744073709551615", "0 0 0\n").into(),
            "the file ends before the last row",
        ),
        (
            "m.ply",
            ply("1", "0 0 x\n").into(),
            "m.ply:10: in element \"vertex\": \"x\" is not a number",
        ),
        (
            "m.ply",
            ply("1", "0 0\n").into(),
            "m.ply:10: in element \"vertex\": the row has too few values",
        ),
        (
            "m.ply",
            ply("1", "0 0 0\n3 0 0 1\n").into(),
            "m.ply:11: a face refers to vertex 1",
        ),
        (
            "m.ply",
            ply("1", "0 0 0\n-3 0 0 1\n").into(),
            "a list has -3 values",
        ),
        (
            "m.ply",
            b"ply\nformat ascii 2.0\nend_header\n".to_vec(),
            "m.ply:2: the line is not part of a PLY header",
        ),
        (
            "m.stl",
            b"short".to_vec(),
            "m.stl: the file is too short for STL",
        ),
        (
            "m.stl",
            vec![0xff; 100],
            "its header states 4294967295 triangles",
        ),
        (
            "m.stl",
            b"solid\nfacet\nouter loop\nvertex 0 0 0\nendloop\n".to_vec(),
            "m.stl:5: a facet has 1 corners",
        ),
    ];
    for (name, bytes, expected) in cases {
        let error = read_mesh(name, &bytes).unwrap_err().to_string();
        assert!(error.contains(expected), "{error}\nwanted: {expected}");
    }
}

#[test]
fn a_cut_file_is_an_error_wherever_it_is_cut() {
    for (name, bytes) in valid_files()
        .into_iter()
        .filter(|(name, _)| *name != "m.obj" && *name != "m.off")
    {
        // The last two bytes may be a line's end and a digit that a shorter number replaces.
        for length in 0..bytes.len() - 12 {
            assert!(
                read_mesh(&name, &bytes[..length]).is_err(),
                "{name} cut at {length} of {}",
                bytes.len()
            );
        }
    }
}

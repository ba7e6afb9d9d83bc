//! Inputs of 100 MB: an answer in seconds, in memory of the order of the input.

use protomer_io::mesh::{MeshFormat, read_mesh, write_mesh};
use protomer_io::points::read_points;
use protomer_kernel::setting::Choices;
use protomer_kernel::{TriangleMesh, Vec3};
use std::time::Instant;

#[test]
#[ignore = "slow; run by name, with --nocapture for the times"]
fn inputs_of_100_megabytes_are_answered() {
    const LENGTH: usize = 100_000_000;
    let junk: Vec<u8> = (0..LENGTH as u64)
        .map(|i| (i.wrapping_mul(0x9E37_79B9_7F4A_7C15) >> 56) as u8)
        .collect();
    let fill = |line: &str| {
        line.as_bytes()
            .iter()
            .copied()
            .cycle()
            .take(LENGTH)
            .collect::<Vec<u8>>()
    };
    let inputs = [
        ("junk", junk),
        ("numbers", fill("1 2 3 ")),
        ("letters", fill("A")),
        ("lines", fill("\n")),
    ];
    for (what, bytes) in &inputs {
        let meshes = MeshFormat::ALL.iter().map(|format| format.name());
        for extension in meshes.chain(["pqr", "xyzr", "xyzq"]) {
            let name = &format!("x.{extension}");
            let start = Instant::now();
            let answer = if MeshFormat::from_name(name).is_ok() {
                read_mesh(name, bytes).map(|_| ())
            } else {
                read_points(name, bytes).map(|_| ())
            };
            let message = answer.unwrap_err().to_string();
            assert!(
                message.starts_with(name) && message.len() < 300,
                "{what} as {name}: {} bytes",
                message.len()
            );
            println!(
                "{:.2} s for {what} as {message}",
                start.elapsed().as_secs_f64()
            );
        }
    }
}

#[test]
#[ignore = "slow; run by name, with --nocapture for the times"]
fn a_mesh_of_a_million_vertices_is_read_in_seconds() {
    let side = 1000u32;
    let vertices = (0..side * side)
        .map(|i| Vec3::new((i % side) as f64, (i / side) as f64, (i as f64).sin()))
        .collect();
    let corner = |i: u32| (i / (side - 1)) * side + i % (side - 1);
    let triangles = (0..(side - 1) * (side - 1)).map(corner);
    let triangles = triangles
        .flat_map(|v| [[v, v + 1, v + side], [v + 1, v + side + 1, v + side]])
        .collect();
    let mesh = TriangleMesh {
        vertices,
        triangles,
    };
    for &format in MeshFormat::ALL {
        let name = &format!("x.{}", format.name());
        let start = Instant::now();
        let bytes = write_mesh(format, &mesh);
        let written = start.elapsed().as_secs_f64();
        let back = read_mesh(name, &bytes).unwrap();
        // STL renumbers its vertices.
        assert_eq!(
            (back.vertices.len(), back.triangles.len()),
            (mesh.vertices.len(), mesh.triangles.len())
        );
        let read = start.elapsed().as_secs_f64() - written;
        println!(
            "{name}: {} MB, written in {written:.2} s, read in {read:.2} s",
            bytes.len() / 1_000_000
        );
    }
}

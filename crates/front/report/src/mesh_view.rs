//! Meshes as data for the viewer: positions in 16 bits, a byte per vertex and colouring, base64.

use base64::prelude::*;
use protomer_common::page::Program;
use protomer_common::page::scene::{Colouring, Film, Scene, Shown, ShownMesh};
use protomer_io::written::json_in_html;
use protomer_kernel::{Pose, Vec3};
use serde_json::{Value, json};

/// Number of vertices up to which meshes have 16-bit indices.
const NARROW: usize = 1 << 16;

/// The viewer.
pub fn program(shown: &Shown) -> Program {
    // Names come from files and stand in a script here.
    let data = json_in_html(&to_json(shown).to_string());
    Program {
        html: include_str!("mesh_view.html").to_owned(),
        style: include_str!("mesh_view.css").to_owned(),
        library: include_str!("mesh_view.js"),
        script: format!("viewMeshes(document.querySelector(\".mesh-view\"), {data});\n"),
    }
}

fn to_json(shown: &Shown) -> Value {
    let colouring = |colouring: &Colouring| {
        let Colouring {
            name,
            unit,
            limit,
            colours,
        } = colouring;
        json!({ "name": name, "unit": unit, "colours": colours, "labels": [format!("−{limit}"), "0", format!("+{limit}")] })
    };
    json!({
        "meshes": shown.meshes.iter().map(|mesh| mesh_to_json(mesh, &shown.colourings)).collect::<Vec<_>>(),
        "colourings": shown.colourings.iter().map(colouring).collect::<Vec<_>>(),
        "scenes": shown.scenes.iter().map(|scene| scene_to_json(scene, &shown.meshes)).collect::<Vec<_>>(),
    })
}

fn mesh_to_json(shown: &ShownMesh, colourings: &[Colouring]) -> Value {
    let mesh = &shown.mesh;
    let Bounds { low, high } = bounds(mesh.vertices.iter());
    // All coordinates are scaled by the longest edge.
    // One span for all axes, or the body would be distorted. A floor for a point.
    let span = (high - low).max().max(1e-3);
    let place = |x: f64, axis: usize| {
        ((x - low[axis]) / span * 65535.0)
            .round()
            .clamp(0.0, 65535.0) as u16
    };
    let places: Vec<u8> = mesh
        .vertices
        .iter()
        .flat_map(|vertex| [0, 1, 2].map(|axis| place(vertex[axis], axis)))
        .flat_map(u16::to_le_bytes)
        .collect();
    // 16-bit indices reach vertex 65 535.
    let wide = mesh.vertices.len() > NARROW;
    let corners = mesh.triangles.iter().flatten();
    let corners: Vec<u8> = match wide {
        true => corners.flat_map(|corner| corner.to_le_bytes()).collect(),
        false => corners
            .flat_map(|corner| (*corner as u16).to_le_bytes())
            .collect(),
    };
    let values = colourings.iter().zip(&shown.values);
    let values: Vec<String> = values
        .map(|(scale, values)| {
            BASE64_STANDARD.encode(
                values
                    .iter()
                    .map(|value| level(*value, scale.limit))
                    .collect::<Vec<_>>(),
            )
        })
        .collect();
    json!({
        "name": shown.name, "low": rounded(&low), "span": thousandths(span), "wide": wide,
        "places": BASE64_STANDARD.encode(&places), "corners": BASE64_STANDARD.encode(&corners), "values": values,
    })
}

/// Level of a value: 1 to 255 from -limit to limit; 0 for no value.
fn level(value: f64, limit: f64) -> u8 {
    // 0 stands for no value, so values take 1 to 255 with zero in the middle, at 128.
    if value.is_nan() {
        0
    } else {
        (128.0 + 127.0 * (value / limit).clamp(-1.0, 1.0)).round() as u8
    }
}

fn scene_to_json(scene: &Scene, meshes: &[ShownMesh]) -> Value {
    let centre = match scene.bodies.as_slice() {
        [(mesh, pose)] => {
            let Bounds { low, high } = bounds(
                meshes
                    .get(*mesh)
                    .iter()
                    .flat_map(|shown| &shown.mesh.vertices),
            );
            // One body turns about the middle of its mesh,
            // several about the mean of their positions.
            pose.transform_point(&(0.5 * (low + high)))
        }
        bodies => {
            bodies.iter().map(|(_, pose)| pose.position).sum::<Vec3>() / bodies.len().max(1) as f64
        }
    };
    let reach = |(mesh, pose): &(usize, Pose)| {
        let vertices = meshes
            .get(*mesh)
            .map_or(&[][..], |shown| &shown.mesh.vertices);
        vertices
            .iter()
            .map(|vertex| (pose.transform_point(vertex) - centre).norm())
            .fold(0.0, f64::max)
    };
    let radius = scene.bodies.iter().map(reach).fold(1.0, f64::max);
    let body = |(mesh, pose): &(usize, Pose)| {
        // Six digits: a quaternion to a millionth turns a body by less than a pixel.
        let [w, x, y, z] = pose.wxyz().map(|part| (part * 1e6).round() / 1e6);
        let position = rounded(&pose.position);
        json!([mesh, position[0], position[1], position[2], w, x, y, z])
    };
    let mut json = json!({
        "name": scene.name, "centre": rounded(&centre), "radius": thousandths(radius),
        "bodies": scene.bodies.iter().map(body).collect::<Vec<_>>(),
    });
    if let Some(colouring) = scene.colouring {
        json["colouring"] = colouring.into();
    }
    if let Some(film) = &scene.film {
        add_film(&mut json, film);
    }
    json
}

/// Adds the frames, the texts next to them, and a view that holds all of them.
fn add_film(json: &mut Value, film: &Film) {
    // Hundredths of an Å and thousandths of a quaternion are more than a screen shows.
    let pose = |pose: &Pose| -> Vec<f64> {
        let place = pose.position.iter().map(|x| (x * 1e2).round() / 1e2);
        place.chain(pose.wxyz().map(thousandths)).collect()
    };
    let frame = |(_, poses): &(String, Vec<Pose>)| poses.iter().map(pose).collect::<Vec<_>>();
    let labels = film.frames.iter().map(|(label, _)| label);
    json["labels"] = json!(labels.collect::<Vec<_>>());
    json["frames"] = json!(film.frames.iter().map(frame).collect::<Vec<_>>());
    let positions = film.frames.iter().flat_map(|(_, poses)| poses);
    let Bounds { low, high } = bounds(positions.map(|pose| &pose.position));
    // Bodies move through the whole box; without one the view must hold all frames.
    let (centre, width) = match film.box_angstrom {
        Some(lengths) => {
            json["box"] = json!(lengths.map(thousandths));
            (Vec3::zeros(), Vec3::from(lengths))
        }
        None => (0.5 * (low + high), high - low),
    };
    let around_a_body = json["radius"].as_f64().unwrap_or(1.0);
    json["centre"] = json!(rounded(&centre));
    // Never smaller than the view of a single body.
    json["radius"] = thousandths((0.5 * width.norm()).max(around_a_body)).into();
}

struct Bounds {
    low: Vec3,
    high: Vec3,
}

fn bounds<'a>(vertices: impl Iterator<Item = &'a Vec3>) -> Bounds {
    let around = |both: Option<Bounds>, vertex: &Vec3| {
        let Bounds { low, high } = both.unwrap_or(Bounds {
            low: *vertex,
            high: *vertex,
        });
        Some(Bounds {
            low: low.inf(vertex),
            high: high.sup(vertex),
        })
    };
    vertices.fold(None, around).unwrap_or(Bounds {
        low: Vec3::zeros(),
        high: Vec3::zeros(),
    })
}

fn rounded(place: &Vec3) -> [f64; 3] {
    [0, 1, 2].map(|axis| thousandths(place[axis]))
}

fn thousandths(x: f64) -> f64 {
    (x * 1e3).round() / 1e3
}

#[cfg(test)]
mod tests {
    use super::*;
    use protomer_kernel::TriangleMesh;

    #[test]
    fn values_keep_their_sign_and_nothing_stays_nothing() {
        assert_eq!(
            [-9.0, -5.0, 0.0, 5.0, f64::NAN].map(|value| level(value, 5.0)),
            [1, 1, 128, 255, 0]
        );
    }

    #[test]
    fn a_film_has_all_its_frames_in_view() {
        let shifted = |x: f64| Pose {
            position: Vec3::new(x, 0.0, 0.0),
            ..Pose::identity()
        };
        let mut scene = Scene {
            name: "film".into(),
            bodies: vec![(0, shifted(0.0))],
            colouring: None,
            film: Some(Film {
                frames: vec![
                    ("sweep 10".into(), vec![shifted(-3.0)]),
                    ("sweep 20".into(), vec![shifted(5.0)]),
                ],
                box_angstrom: None,
            }),
        };
        let json = scene_to_json(&scene, &[]);
        assert_eq!(json["labels"], json!(["sweep 10", "sweep 20"]));
        assert_eq!(
            json["frames"][1],
            json!([[5.0, 0.0, 0.0, 1.0, 0.0, 0.0, 0.0]])
        );
        assert_eq!(json["centre"], json!([1.0, 0.0, 0.0]));
        assert_eq!(json["radius"], json!(4.0));
        assert!(json["box"].is_null());
        if let Some(film) = &mut scene.film {
            film.box_angstrom = Some([30.0, 40.0, 120.0]);
        }
        let json = scene_to_json(&scene, &[]);
        assert_eq!(json["box"], json!([30.0, 40.0, 120.0]));
        assert_eq!(
            (&json["centre"], &json["radius"]),
            (&json!([0.0, 0.0, 0.0]), &json!(65.0))
        );
    }

    #[test]
    fn positions_are_kept_to_a_part_in_65535_of_the_longest_edge() {
        let vertices = vec![
            Vec3::new(-1.0, 2.0, 0.0),
            Vec3::new(3.0, 2.5, 0.0),
            Vec3::new(0.3, 2.1, 1.0),
        ];
        let mesh = TriangleMesh {
            vertices,
            triangles: vec![[0, 1, 2]],
        };
        let json = mesh_to_json(
            &ShownMesh {
                name: "a".into(),
                mesh,
                values: vec![],
            },
            &[],
        );
        assert_eq!(
            (json["span"].as_f64(), json["low"][1].as_f64()),
            (Some(4.0), Some(2.0))
        );
        // 0.325 of 65535 is 21299 (0x5333), 0.025 is 1638 (0x0666), a quarter is 16384 (0x4000);
        // low byte first.
        let expected = [
            0, 0, 0, 0, 0, 0, 0xff, 0xff, 0x00, 0x20, 0, 0, 0x33, 0x53, 0x66, 0x06, 0x00, 0x40,
        ];
        assert_eq!(json["places"], BASE64_STANDARD.encode(expected));
        assert_eq!(json["corners"], BASE64_STANDARD.encode([0, 0, 1, 0, 2, 0]));
    }
}

// Readers of the benchmark states, shared by the tests and the benchmark.

fn read_off(path: &Path) -> TriangleMesh {
    let text = std::fs::read_to_string(path).expect("readable");
    let mut words = text.split_whitespace().skip(1);
    let mut next = || words.next().expect("complete");
    let (vertices, triangles): (usize, usize) = (next().parse().expect("a count"), next().parse().expect("a count"));
    next();
    let mut number = || next().parse::<f64>().expect("a number");
    let vertices = (0..vertices).map(|_| Vec3::new(number(), number(), number())).collect();
    let corners = |number: &mut dyn FnMut() -> f64| {
        number();
        [number() as u32, number() as u32, number() as u32]
    };
    TriangleMesh { vertices, triangles: (0..triangles).map(|_| corners(&mut number)).collect() }
}

fn read_charges(path: &Path) -> Vec<(Vec3, f64)> {
    let text = std::fs::read_to_string(path).expect("readable");
    let numbers: Vec<f64> = text.split_whitespace().map(|word| word.parse().expect("a number")).collect();
    numbers.chunks_exact(4).map(|row| (Vec3::new(row[0], row[1], row[2]), row[3])).collect()
}

fn read_assembly(path: &Path) -> (Boundary, Vec<(usize, Pose)>) {
    let text = std::fs::read_to_string(path).expect("readable");
    let json: serde_json::Value = serde_json::from_str(&text).expect("JSON");
    let number = |value: &serde_json::Value, index: usize| value[index].as_f64().expect("a number");
    let vector = |value: &serde_json::Value| Vec3::new(number(value, 0), number(value, 1), number(value, 2));
    let bodies = json["placements"].as_array().expect("a list").iter().map(|placement| {
        let q = &placement["orientation_wxyz"];
        let pose = Pose::from_wxyz(
            vector(&placement["position_angstrom"]),
            [number(q, 0), number(q, 1), number(q, 2), number(q, 3)],
        );
        (usize::from(placement["body"] == "b"), pose)
    });
    let boundary = Boundary::periodic(vector(&json["box_angstrom"])).expect("a box");
    (boundary, bodies.collect())
}

//! Pages of hard bodies, lattices, frameworks and voxel sets.

use super::{carries, page, read, status, words};
use crate::common::{TemporaryFolder, contents, is_ok, message};
use protomer_results::Row;
use protomer_shape_verbs::dynamics;
use std::path::Path;

#[test]
fn contact_dynamics_has_its_course_and_bodies_of_every_kind() {
    let place = TemporaryFolder::new();
    std::fs::write(
        place.path("pairs.csv"),
        "distance,energy_kt\n2,2\n3,1\n4,0\n",
    )
    .unwrap();
    std::fs::write(
        place.path("valley.csv"),
        "height,energy_kt\n0,1\n5,0\n10,1\n",
    )
    .unwrap();
    is_ok(&place.run(
        "md run --shape ellipsoid:2,1,1 --keep-size --bodies 32 --packing-fraction 0.1 --steps 40 \
         --compress-steps 20 --equilibrate-steps 20 --log-every 10 --trajectory-every 20 --pair-potential pairs.csv \
         --field valley.csv -q -o ellipsoids",
    ));
    let (html, sections) = page(&place, "ellipsoids");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    assert!(status(&html).contains("<strong>Equilibrated: unknown.</strong>"));
    carries(&html, &place.path("ellipsoids/log.csv"));
    assert!(html.contains("after 40 steps") && html.contains("<dt>Pressure</dt>"));
    assert_eq!(html.matches("<svg").count(), 2, "the course in two shapes");
    let words = words(&html);
    for curve in dynamics::log::LogRow::curves() {
        for name in [curve.panel, curve.name] {
            assert!(words.contains(name), "{name}");
        }
    }

    let mixture = "md run --shape polygon:4 --shape polygon:5 --share 3 --share 1 --bodies 36 --packing-fraction 0.3 \
                   --steps 20 --compress-steps 20 --equilibrate-steps 20 --trajectory-every 20 -q -o";
    is_ok(&place.run(&format!("{mixture} mixture")));
    let (html, _) = page(&place, "mixture");
    assert!(html.contains("body 1") && html.contains("body 2"));
    assert_eq!(
        place
            .run(&format!("{mixture} stopped --time-limit 0"))
            .status
            .code(),
        Some(3)
    );
    assert!(message(&place.run("report stopped")).contains("work that has not begun"));
}

#[test]
fn hard_bodies_have_their_averages_their_course_and_their_bodies() {
    let place = TemporaryFolder::new();
    let cubes = "--shape cube --bodies 27 --equilibration 10 --sweeps 40 -q";
    is_ok(&place.run(&format!(
        "hpmc run --packing-fraction 0.1 --insertions 10 {cubes} -o cubes"
    )));
    let (html, sections) = page(&place, "cubes");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    carries(&html, &place.path("cubes/log.csv"));
    let words = words(&html);
    for panel in ["compressibility factor", "insertion probability"] {
        assert!(words.contains(panel), "{panel}");
    }
    assert!(!words.contains("mean height"), "there are no walls");

    is_ok(&place.run(&format!(
        "hpmc sweep --packing-fractions 0.05,0.1 {cubes} -o equation"
    )));
    let (html, sections) = page(&place, "equation");
    assert_eq!(sections, ["Status", "Results", "Bodies", "Provenance"]);
    carries(&html, &place.path("equation/equation.csv"));
}

#[test]
fn lattices_frameworks_and_trainings_have_pages_too() {
    let place = TemporaryFolder::new();
    let lattice = "lattice run --rows 4 --columns 4 --velocities random --steps 60 --log-every 5";
    is_ok(&place.run(&format!("{lattice} --trajectory-every 10 -q -o run")));
    let (html, sections) = page(&place, "run");
    assert_eq!(
        sections,
        ["Status", "Animation", "History", "Conditions", "Provenance"]
    );
    carries(&html, &place.path("run/log.csv"));
    assert!(html.contains("7 frames") && html.contains("playLattice("));
    is_ok(&place.run(&format!("{lattice} --trajectory-every 0 -q -o still")));
    let (html, sections) = page(&place, "still");
    assert!(
        html.contains("The run cannot be played") && !sections.contains(&"Animation".to_owned())
    );
    assert!(
        !html.contains("playLattice("),
        "what is not needed is not carried"
    );

    std::fs::write(
        place.path("sweep.toml"),
        "rows = 3\ncolumns = 3\nsteps = 40\n[sweep]\nr0 = [0.1, 0.2]\nseeds = [1, 2]\n",
    )
    .unwrap();
    is_ok(&place.run("lattice sweep sweep.toml -q -o lattices"));
    let (html, sections) = page(&place, "lattices");
    assert_eq!(
        sections,
        [
            "Status",
            "Results",
            "Animation",
            "Conditions",
            "Runs",
            "Provenance"
        ]
    );
    carries(&html, &place.path("lattices/lattice.csv"));
    carries(&html, &place.path("lattices/runs.csv"));
    std::fs::remove_dir_all(place.path("lattices/r0_0.2_kappa_0/seed_2")).unwrap();
    assert!(
        page(&place, "lattices")
            .0
            .contains("r0 = 0.2, κ = 0, seed 2: no record; it was not started")
    );

    is_ok(&place.run("framework honeycomb --theta 60 --kh 50 --ks 10000 --load y --stress 20GPa,40GPa -q -o pulled"));
    let (html, sections) = page(&place, "pulled");
    assert_eq!(
        sections,
        ["Status", "Results", "Network", "Conditions", "Provenance"]
    );
    for table in ["polar.csv", "stiffness.csv", "curve.csv"] {
        carries(&html, &place.path(&format!("pulled/{table}")));
    }
    assert_eq!(
        html.matches("<svg").count(),
        6,
        "polar plot and curve in two shapes, drawing, deformation"
    );
    assert!(
        html.contains("<div class=\"narrow\">\n<p>honeycomb"),
        "the drawing's texts stand below it"
    );

    let trained = place.run("train --control orientation --short --epochs 3 -q -o training");
    is_ok(&trained);
    let (html, sections) = page(&place, "training");
    assert!(status(&html).contains("<strong>Control passed: "));
    // The terminal and the page say the same of a prediction with certainty.
    assert!(html.contains("<td>majority</td>"));
    let (_, row) = html.split_once("<td>majority</td>").unwrap();
    let (row, _) = row.split_once("</tr>").unwrap();
    assert!(row.ends_with("<td>–</td><td>–</td>"), "{row}");
    assert!(html.contains("does not test the gain over the prior"));
    assert_eq!(
        sections,
        [
            "Status",
            "Scores",
            "Confusion",
            "Control",
            "Conditions",
            "Provenance"
        ]
    );
    carries(&html, &place.path("training/history.csv"));
    std::fs::remove_file(place.path("training/metrics.json")).unwrap();
    assert!(
        page(&place, "training")
            .0
            .contains("The training is not finished")
    );
}

#[test]
fn tables_of_networks_have_a_page() {
    let place = TemporaryFolder::new();
    is_ok(&place.run("framework tables -q -o tables"));
    let (html, sections) = page(&place, "tables");
    assert_eq!(
        sections,
        ["Status", "Results", "How to read the tables", "Provenance"]
    );
    // Every number that is printed, as the terminal shows it, and every one computed, digit for
    // digit.
    let rows: serde_json::Value =
        serde_json::from_str(&read(&place.path("tables/tables.json"))).unwrap();
    let values: Vec<&serde_json::Value> = rows
        .as_array()
        .unwrap()
        .iter()
        .flat_map(|row| row["values"].as_array().unwrap())
        .collect();
    assert_eq!(values.len(), 168);
    for value in values {
        let printed = value["printed"].as_str().unwrap();
        assert!(html.contains(&format!(" | {printed} ")), "{printed}");
        assert!(
            html.contains(&format!(",{},{printed},", value["computed"])),
            "{value}"
        );
    }
    std::fs::write(place.path("tables/tables.json"), "[{\"table\": 2}]").unwrap();
    assert!(message(&place.run("report tables --force")).contains("tables.json"));
}

/// Sixteen times one protein in two classes, and a file that is not there.
fn voxels(place: &TemporaryFolder) {
    let structure =
        Path::new(env!("CARGO_MANIFEST_DIR")).join("../../../data/structures/5pti.cif.gz");
    let mut manifest = "file,label,cluster,name\n".to_owned();
    for number in 0..16 {
        let label = if number % 2 == 0 { "even" } else { "odd" };
        manifest += &format!(
            "{},{label},c{},s{number}\n",
            structure.display(),
            number / 2
        );
    }
    manifest += "missing.pdb,odd,c,<gone>\n";
    std::fs::write(place.path("set.csv"), manifest).unwrap();
}

const VOXELIZE: &str = "voxelize --manifest set.csv -o set.zarr --size 24 --spacing 2 --channels shape,potential --potential debye-hueckel -q";

#[test]
fn a_set_of_voxels_and_a_search_have_pages_too() {
    let place = TemporaryFolder::new();
    voxels(&place);
    assert_eq!(
        place
            .run(&format!("{VOXELIZE} --time-limit 0"))
            .status
            .code(),
        Some(3)
    );
    assert!(message(&place.run("report set.zarr")).contains("not complete yet"));
    is_ok(&place.run(VOXELIZE));
    let before = contents(&place.path("set.zarr"));
    let output = place.run("report set.zarr");
    is_ok(&output);
    assert!(
        String::from_utf8_lossy(&output.stdout)
            .starts_with("set.zarr.report.html: Status, Samples, ")
    );
    assert_eq!(
        contents(&place.path("set.zarr")),
        before,
        "nothing is added to the group"
    );
    let html = read(&place.path("set.zarr.report.html"));
    assert!(html.contains("1 of 17 structures were left out (unreadable: 1)."));
    assert!(html.contains("<td>&lt;gone&gt;</td><td>odd</td><td>unreadable</td>"));
    // label, samples, clusters, left out; the first cluster; the channel that is 1 everywhere.
    assert!(
        html.contains("<td>odd</td><td>8</td><td>8</td><td>1</td>"),
        "labels"
    );
    assert!(
        html.contains("<td>c0</td><td>2</td><td>even, odd</td>"),
        "clusters"
    );
    assert!(
        html.contains("<td>1</td><td>1</td><td>0</td><td>1</td><td>unchanged</td>"),
        "channels"
    );
    assert!(
        html.contains("arcsinh(x / ") && html.contains("2 Å") && html.contains("debye-hueckel")
    );
    // The occupied voxels that the page has are those of the set.
    let group: serde_json::Value =
        serde_json::from_str(&read(&place.path("set.zarr/zarr.json"))).unwrap();
    let attributes = &group["attributes"];
    for key in ["identity", "manifest_sha256", "made_by"] {
        assert!(html.contains(attributes[key].as_str().unwrap()), "{key}");
    }
    let set =
        protomer_learn_verbs::voxels::samples::VoxelSet::open(&place.path("set.zarr")).unwrap();
    let voxels: usize = (0..16).map(|sample| set.reader().voxels(sample)).sum();
    assert!(html.contains(&format!("<dd>{voxels}, {} per sample</dd>", voxels / 16)));
    assert_eq!(
        html.matches("s15,odd,c7,").count(),
        1,
        "the table of samples"
    );

    is_ok(&place.run("tune set.zarr --least-samples 5 --trials 3 --epochs 3 -q -o search"));
    let (html, sections) = page(&place, "search");
    assert_eq!(
        sections,
        [
            "Status",
            "Best settings",
            "Trials",
            "Conditions",
            "Provenance"
        ]
    );
    carries(&html, &place.path("search/trials.csv"));
    assert_eq!(html.matches("<svg").count(), 2);
    let best = read(&place.path("search/trials.csv"))
        .lines()
        .nth(1)
        .unwrap()
        .split(',')
        .next()
        .unwrap()
        .to_owned();
    assert!(html.contains(&format!("<dt>trial</dt><dd>{best}</dd>")) && html.contains("best.toml"));
    assert!(html.contains("nothing failed and nothing is missing"));
    std::fs::remove_file(place.path("search/best.toml")).unwrap();
    assert!(
        page(&place, "search")
            .0
            .contains("The search is not finished")
    );
    std::fs::remove_file(place.path("search/trials.csv")).unwrap();
    assert!(page(&place, "search").0.contains("There is no table yet"));
}

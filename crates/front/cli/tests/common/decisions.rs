//! Decisions that made sentences false, and the words that no page, help text or figure may say
//! any more. A change that makes sentences false adds a row here.

use std::path::{Path, PathBuf};

/// A decision.
struct Decision {
    /// When it was made.
    date: &'static str,
    /// What holds since then.
    holds: &'static str,
    /// What was said before, in lower case and with single spaces.
    forbidden: &'static [&'static str],
}

const DECISIONS: &[Decision] = &[
    Decision {
        date: "2026-11-22",
        holds: "charges interact without a cut-off, over as many images of a box as they reach; \
                --cutoff is for comparisons only",
        forbidden: &[
            "cut and not shifted",
            "must stay below half the box",
            "at most half-way across the box",
            "so that each body interacts with one image",
            "its cut-off is too long",
            "too small for the cut-off",
            "a longer `--cutoff`",
            "a larger box, or `--cutoff`",
            "or a `--cutoff` where the potential is weak",
            ">cut-off</text>",
        ],
    },
    Decision {
        date: "2026-11-26",
        holds: "`hpmc`, `md`, `free-energy` and `phase-diagram` take convex bodies and unions of them, \
                at constant pressure and in triclinic boxes",
        forbidden: &[
            "every shape is a mesh",
            "or a spherical wall. constant volume",
            "other potentials, other ensembles and gpus",
        ],
    },
    Decision {
        date: "2026-11-28",
        holds: "the thesis speaks of the -3 and -1 kT contours of the potential of mean force, not of \
                depths of its wells",
        forbidden: &["in the thesis -3 and gone"],
    },
    Decision {
        date: "2026-11-28",
        holds: "the tilted stack of supercharged GFPs is our own recipe; in the cryo-EM structure one \
                kind lies across the axis",
        forbidden: &[
            "lean, as in the cryo-em structure",
            "is neither confirmed nor contradicted",
        ],
    },
    Decision {
        date: "2026-11-28",
        holds: "tests that need data are ignored by name (PROTOMER_TEST_DATA); none passes without \
                having compared anything",
        forbidden: &["skipped where it is absent", "eprintln!(\"skipped: {} is"],
    },
    Decision {
        date: "2026-11-28",
        holds: "each kind of results that a verb writes has a page, and messages take the verbs from \
                the kinds",
        forbidden: &[
            "pair, hpmc run, hpmc sweep, free-energy, lattice run, lattice sweep, framework",
        ],
    },
];

/// Where sentences for users stand, below the root.
const FOLDERS: &[&str] = &[
    "docs",
    "notebooks",
    "crates",
    "python",
    "tests/validation",
    "data",
];
const FILES: &[&str] = &[
    "README.md",
    "ARCHITECTURE.md",
    "CONTRIBUTING.md",
    "CITATION.cff",
    "mkdocs.yml",
];
const ENDINGS: &[&str] = &[
    "md", "svg", "rs", "py", "pyi", "ipynb", "sh", "toml", "html",
];

/// The text in lower case with single spaces, without the signs that begin the lines of comments,
/// and for each byte the line that it comes from.
fn flowing(text: &str) -> (String, Vec<usize>) {
    let (mut words, mut lines) = (String::with_capacity(text.len()), Vec::new());
    for (number, line) in (1..).zip(text.lines()) {
        let line = line.trim_start();
        let line = ["///", "//!", "//", "#"]
            .iter()
            .find_map(|sign| line.strip_prefix(sign))
            .unwrap_or(line);
        for word in line.split_whitespace() {
            words += &word.to_lowercase();
            words.push(' ');
            lines.resize(words.len(), number);
        }
    }
    (words, lines)
}

/// The forbidden words of a text: line, words, decision.
fn false_sentences(text: &str) -> Vec<String> {
    let (words, lines) = flowing(text);
    let mut found = Vec::new();
    for Decision {
        date,
        holds,
        forbidden,
    } in DECISIONS
    {
        for phrase in *forbidden {
            for (place, _) in words.match_indices(phrase) {
                found.push(format!(
                    "{}: says '{phrase}', but since {date} {holds}",
                    lines[place]
                ));
            }
        }
    }
    found
}

fn files_below(folder: &Path, files: &mut Vec<PathBuf>) {
    for entry in std::fs::read_dir(folder).unwrap() {
        let path = entry.unwrap().path();
        let name = path.file_name().unwrap_or_default().to_string_lossy();
        let ending = path.extension().unwrap_or_default().to_string_lossy();
        if path.is_dir() {
            // Virtual environments, caches and the like are not ours.
            if !name.starts_with(['.', '_'])
                && !path.join("pyvenv.cfg").exists()
                && name != "target"
            {
                files_below(&path, files);
            }
        } else if ENDINGS.contains(&ending.as_ref()) && !path.ends_with(file!()) {
            files.push(path);
        }
    }
}

#[test]
fn no_sentence_survives_the_decision_that_made_it_false() {
    let root = Path::new(env!("CARGO_MANIFEST_DIR")).join("../../..");
    let mut files: Vec<PathBuf> = FILES.iter().map(|file| root.join(file)).collect();
    for folder in FOLDERS {
        files_below(&root.join(folder), &mut files);
    }
    let mut found = Vec::new();
    for file in files {
        let Ok(text) = std::fs::read_to_string(&file) else {
            continue;
        };
        for sentence in false_sentences(&text) {
            let path = file.strip_prefix(&root).unwrap_or(&file);
            found.push(format!("{}:{sentence}", path.display()));
        }
    }
    assert!(found.is_empty(), "{}", found.join("\n"));
}

#[test]
fn false_sentences_are_found_across_lines_with_their_line() {
    let text = "/// True.\n/// The potential is cut and\n///   NOT shifted here.\n";
    let found = false_sentences(text);
    assert_eq!(found.len(), 1, "{found:?}");
    assert!(
        found[0].starts_with("2: says 'cut and not shifted', but since 2026-11-22 charges"),
        "{found:?}"
    );
    assert_eq!(false_sentences("no cut-off"), Vec::<String>::new());
}

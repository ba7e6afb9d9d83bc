//! What the help adds to the table of flags: verbs in groups, examples, and values that may start with
//! a minus.

use clap::builder::StyledStr;
use clap::error::{ContextKind, ContextValue, ErrorKind};
use clap::{Arg, ArgAction, Command};
use protomer_body::structure::Format;
use protomer_common::input::is_pdb_entry;
use protomer_protein_verbs::file_kind::FileKind;
use std::ffi::OsString;
use std::path::Path;

/// Groups of verbs, in the order of the help.
const GROUPS: [(&str, &[&str]); 8] = [
    ("Structures", &["fetch", "ingest", "surface", "body"]),
    (
        "Assemblies",
        &["assemble", "candidates", "inspect", "export"],
    ),
    (
        "Stability",
        &[
            "stability",
            "simulate",
            "sweep",
            "residues",
            "reweight",
            "compare",
            "pair",
            "binding",
            "score",
            "scattering",
        ],
    ),
    ("Potentials", &["potential", "titrate"]),
    (
        "Learning",
        &["voxelize", "merge", "train", "tune", "predict"],
    ),
    ("Lattices", &["lattice", "framework"]),
    (
        "Hard shapes",
        &["shape", "hpmc", "free-energy", "md", "phase-diagram"],
    ),
    ("Tools", &["report", "bench", "completions", "man", "help"]),
];

/// Two examples of each verb, without the name of the program.
const EXAMPLES: &[(&str, [&str; 2])] = &[
    ("fetch", ["fetch 6MDR -o structures", "fetch 5PTI 1BRS"]),
    (
        "ingest",
        [
            "ingest 5pti.cif.gz -o bodies",
            "ingest 5pti.cif.gz -o bodies --name plus --ph 7 --mutate A:D3K,A:E7K",
        ],
    ),
    (
        "surface",
        [
            "surface 5pti.cif.gz -o bpti.ply",
            "surface spheres.xyzr --probe 1.4 --density 4 --json",
        ],
    ),
    (
        "body",
        [
            "body --mesh patchy.ply --charges patchy.xyzq -o patchy.body",
            "body --mesh cube.off -o cube.body",
        ],
    ),
    (
        "assemble",
        [
            "assemble structure 1brs.cif.gz --chain A,D --relax -o complex",
            "assemble ring a.body b.body --members 4 --box 320 -o ring.json",
        ],
    ),
    (
        "assemble structure",
        [
            "assemble structure receptor.pdb ligand.pdb --box 300 -o complex",
            "assemble structure 6mdr.cif.gz --assembly 1 --box 400 -o stack",
        ],
    ),
    (
        "assemble ring",
        [
            "assemble ring a.body b.body --members 4 --box 320 -o ring.json",
            "assemble ring a.body b.body --members 8 --stack 2 --directions ud -o stack.json",
        ],
    ),
    (
        "assemble fluid",
        [
            "assemble fluid a.body b.body --counts 8,8 --box 500 -o fluid.json",
            "assemble fluid a.body --counts 20 --box 400 --seed 7 -o fluid.json",
        ],
    ),
    (
        "candidates",
        [
            "candidates a.body b.body --ring 8 --stack 2",
            "candidates a.body b.body --ring 4 --stack 2 --box 320 -o candidates",
        ],
    ),
    (
        "inspect",
        [
            "inspect ring.json",
            "inspect ring.json --salt 100mM --interaction effective",
        ],
    ),
    (
        "export",
        [
            "export ring.json -o ring.cif --script chimerax",
            "export stability --salt 300mM --frame last -o end.pdb",
        ],
    ),
    (
        "scattering",
        [
            "scattering stability -o scattering",
            "scattering ring.json --q-max 0.2 --json",
        ],
    ),
    (
        "simulate",
        [
            "simulate ring.json --salt 100mM -o run",
            "simulate ring.json --salt 0.1M --sweeps 5000 --interaction effective -o run",
        ],
    ),
    (
        "sweep",
        [
            "sweep ring.json --salt 10mM..300mM/8 --replicas 4 -o stability",
            "sweep ring.json --salt 10mM,50mM,250mM --starts both --exchange-every 20 -o equilibrium",
        ],
    ),
    (
        "residues",
        [
            "residues stability --salt 100mM --mutations",
            "residues ring.json --salt 100mM -o holds --script pymol",
        ],
    ),
    (
        "reweight",
        [
            "reweight stability -o curves",
            "reweight stability --salt 50mM..200mM/20 --concentration 1uM,100uM",
        ],
    ),
    (
        "compare",
        [
            "compare spin_0 spin_90 -o spins.svg",
            "compare stability --title Ring -o ring.png",
        ],
    ),
    (
        "stability",
        [
            "stability 4hhb.cif.gz --salt 50mM,150mM,500mM --concentration 1uM",
            "stability 6mdr/assembly.json --salt 50mM..1M/6 --concentration 100nM,1uM -o yields",
        ],
    ),
    (
        "score",
        [
            "score designs -o scores --columns energy,area,shape",
            "score complexes.csv -o scores --columns affinity,kd --salt 50mM,150mM",
        ],
    ),
    (
        "binding",
        [
            "binding receptor.pdb ligand.pdb --salt 50mM,150mM,500mM",
            "binding complex.cif.gz --body H,L --body A --salt 150mM,50mM --ph 6,7.4 --exchanges",
        ],
    ),
    (
        "pair",
        [
            "pair 4lzt.pdb.gz --salt 100mM,300mM --ph 4.5 --interaction effective -o lysozyme",
            "pair a.body b.body --salt 10mM..1M/8 -o association",
        ],
    ),
    (
        "titrate",
        [
            "titrate 5pti.cif.gz --ph 7 --salt 100mM",
            "titrate 5pti.cif.gz --ph 2..12 --salt 100mM -o titration",
        ],
    ),
    (
        "potential",
        [
            "potential 5pti.cif.gz --salt 100mM -o bpti.mrc",
            "potential a.body --salt 0.15M --points points.txt --json",
        ],
    ),
    (
        "voxelize",
        [
            "voxelize --manifest set.csv -o set.zarr --seed 1",
            "voxelize --manifest set.csv --shard 1/4 -o part1.zarr",
        ],
    ),
    (
        "merge",
        [
            "merge part1.zarr part2.zarr -o set.zarr",
            "merge a.zarr b.zarr -o both.zarr --force",
        ],
    ),
    (
        "train",
        [
            "train set.zarr --target crystal-system --epochs 40 -o run",
            "train --control charge --short -o charge",
        ],
    ),
    (
        "tune",
        [
            "tune set.zarr --target crystal-system --trials 27 -o search",
            "tune set.zarr --trials 9 --shard 1/4 -o search",
        ],
    ),
    (
        "predict",
        [
            "predict run new.zarr -o predictions.csv",
            "predict run new.zarr --json",
        ],
    ),
    (
        "lattice",
        [
            "lattice run --ns 10 --r0 0.05 --time 3 -o coherent",
            "lattice --from bodies/square.body",
        ],
    ),
    (
        "lattice run",
        [
            "lattice run --ns 10 --r0 0.05 --time 3 -o coherent",
            "lattice run square.toml --time 10 -o rhua",
        ],
    ),
    (
        "lattice sweep",
        [
            "lattice sweep --ns 4 --r0-list 0.05,0.5,1 --kappa-list 0,10 --seeds 3 -o sweep",
            "lattice sweep --ns 2 --r0-list 0.25,0.5 --seeds 2 --lyapunov -o chaos",
        ],
    ),
    (
        "lattice elastic",
        [
            "lattice elastic pulled pushed",
            "lattice elastic warm --discard 0.2 --blocks 10",
        ],
    ),
    (
        "lattice divergence",
        [
            "lattice divergence chaos --column checkerboard",
            "lattice divergence chaos --radius 0.1 --fit-to 8",
        ],
    ),
    (
        "lattice joint",
        [
            "lattice joint bodies/square.body --salt 100mM --rod 8A -o joint.csv",
            "lattice joint bodies/square.body --salt 20mM --rod 8A --turned-over",
        ],
    ),
    (
        "lattice animate",
        [
            "lattice animate coherent",
            "lattice animate coherent -o coherent.html --frames frames",
        ],
    ),
    (
        "framework",
        [
            "framework honeycomb --theta 60 --kh 50 --ks 10000",
            "framework net.toml --load y --stress 1GPa,2GPa -o pulled",
        ],
    ),
    (
        "shape",
        ["shape cube --rounding 0.1", "shape corners.txt -o hull.ply"],
    ),
    (
        "shape virial",
        [
            "shape virial cube tetrahedron",
            "shape virial cube --triples 100000 --depletants 0.1:5",
        ],
    ),
    (
        "shape free-volume",
        [
            "shape free-volume cube --packing-fraction 0.3 --depletant-radius 0.1",
            "shape free-volume ellipsoid:1,1,3 --packing-fraction 0.1,0.2 --depletant-radius 0.05",
        ],
    ),
    (
        "md",
        [
            "md run --shape polygon:4 --packing-fraction 0.6 -o squares",
            "md run --shape octahedron --bodies 500 --potential smooth --ensemble nvt -o fluid",
        ],
    ),
    (
        "md run",
        [
            "md run --shape polygon:4 --packing-fraction 0.6 -o squares",
            "md run --shape octahedron --bodies 500 --potential smooth --ensemble nvt -o fluid",
        ],
    ),
    (
        "hpmc",
        [
            "hpmc run --shape cube --packing-fraction 0.3 -o cubes",
            "hpmc run --shape cube --packing-fraction 0.3 --depletants 0.1:20 -o depleted",
        ],
    ),
    (
        "hpmc run",
        [
            "hpmc run --shape cube --packing-fraction 0.3 -o cubes",
            "hpmc run --shape cube --packing-fraction 0.3 --depletants 0.1:20 -o depleted",
        ],
    ),
    (
        "free-energy",
        [
            "free-energy --shape cube --crystal simple-cubic --bodies 64 --packing-fraction 0.6 -o cubes",
            "free-energy --shape rod:1 --crystal row --bodies 32 --packing-fraction 0.5 -o rods",
        ],
    ),
    (
        "phase-diagram",
        [
            "phase-diagram --size-ratio 0.5 --reservoir 0.4,0.5,0.6",
            "phase-diagram --branch fluid.txt --branch solid.txt",
        ],
    ),
    (
        "report",
        [
            "report stability",
            "report coherent -o coherent.html --force",
        ],
    ),
    (
        "bench",
        [
            "bench ring.json --salt 300mM --moves 2000",
            "bench --part charges --charges 500",
        ],
    ),
    ("completions", ["completions bash", "completions zsh"]),
    ("man", ["man", "man -o ~/.local/share/man/man1"]),
];

/// Largest width of the list of verbs.
const WIDTH: usize = 100;
/// Column at which the descriptions of verbs begin.
const INDENT: usize = 17;

/// The command line as clap derives it from the flags, with what this module adds.
pub fn completed(derived: Command) -> Command {
    let list = grouped(&derived);
    let template = format!(
        "{{about-with-newline}}\n{{usage-heading}} {{usage}}\n\n{list}Options:\n{{options}}\n\n\
         'protomer VERB --help' shows the flags of a verb, with examples."
    );
    with_examples(derived, "").help_template(template)
}

/// The verbs in groups, each with the beginning of its description.
fn grouped(derived: &Command) -> String {
    let mut list = String::new();
    for (group, verbs) in GROUPS {
        let is_built = |name: &&&str| **name == "help" || derived.find_subcommand(name).is_some();
        let verbs: Vec<&&str> = verbs.iter().filter(is_built).collect();
        if verbs.is_empty() {
            continue;
        }
        list.push_str(&format!("{group}:\n"));
        for name in verbs {
            let verb = derived.find_subcommand(name);
            let about = verb.and_then(Command::get_about).map(ToString::to_string);
            let about = about.unwrap_or_else(|| "Print the help of a verb".into());
            let mut line = format!("  {name:<width$}", width = INDENT - 2);
            for word in beginning(&about).split(' ') {
                if line.chars().count() + word.chars().count() > WIDTH {
                    list.push_str(line.trim_end());
                    line = format!("\n{:INDENT$}", "");
                }
                line.push_str(word);
                line.push(' ');
            }
            list.push_str(line.trim_end());
            list.push('\n');
        }
        list.push('\n');
    }
    list
}

/// The first sentence, up to a colon.
fn beginning(about: &str) -> &str {
    let end = [". ", ": "]
        .iter()
        .filter_map(|mark| about.find(mark))
        .min();
    about[..end.unwrap_or(about.len())].trim_end_matches('.')
}

/// The examples of a verb, by its name after that of the program.
pub fn examples_of(path: &str) -> &'static [&'static str] {
    match EXAMPLES.iter().find(|(verb, _)| *verb == path) {
        Some((_, examples)) => examples,
        None => &[],
    }
}

/// Adds the examples of this verb and those below it; `path` is its name after that of the program.
fn with_examples(verb: Command, path: &str) -> Command {
    let verb = verb.mut_args(minus_is_no_flag);
    let verb = match examples_of(path) {
        [first, second] => verb.after_long_help(format!(
            "Examples:\n  protomer {first}\n  protomer {second}"
        )),
        _ => verb,
    };
    verb.mut_subcommands(|below| {
        let path = format!("{path} {}", below.get_name());
        with_examples(below, path.trim_start())
    })
}

/// Lets a flag take a number below zero as its value; the flag itself then states whether it may be
/// negative.
fn minus_is_no_flag(arg: Arg) -> Arg {
    let takes_value = matches!(arg.get_action(), ArgAction::Set | ArgAction::Append);
    match takes_value && !arg.is_positional() && !arg.is_allow_hyphen_values_set() {
        true => arg.allow_negative_numbers(true),
        false => arg,
    }
}

/// The error without the advice to write a value that starts with a minus behind `--`: that makes
/// it a separate argument.
pub fn without_double_dash(mut error: clap::Error) -> clap::Error {
    let Some(ContextValue::StyledStrs(tips)) = error.remove(ContextKind::Suggested) else {
        return error;
    };
    let is_helpful = |tip: &StyledStr| !tip.to_string().contains("'-- ");
    let tips: Vec<StyledStr> = tips.into_iter().filter(is_helpful).collect();
    if !tips.is_empty() {
        error.insert(ContextKind::Suggested, ContextValue::StyledStrs(tips));
    }
    error
}

/// The error for a word that is not a number, in words of this program: those of the standard library say
/// nothing to a user.
pub fn with_plain_number(error: clap::Error) -> clap::Error {
    let cause = std::error::Error::source(&error).map(ToString::to_string);
    let remedy = match cause.as_deref() {
        Some("invalid float literal" | "cannot parse float from empty string") => {
            "write a number such as 0.5"
        }
        Some("invalid digit found in string" | "cannot parse integer from empty string") => {
            "write a whole number such as 5"
        }
        _ => return error,
    };
    let text = |kind: ContextKind| error.get(kind).map(ToString::to_string);
    let (Some(flag), Some(value)) = (
        text(ContextKind::InvalidArg),
        text(ContextKind::InvalidValue),
    ) else {
        return error;
    };
    clap::Error::raw(
        ErrorKind::ValueValidation,
        format!(
            "invalid value '{value}' for '{flag}': {remedy}\n\nFor more information, try '--help'.\n"
        ),
    )
}

/// The error for a verb that this build does not have, with the way to get it.
pub fn with_missing_feature(error: clap::Error, syntax: &mut Command) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let is_verb = GROUPS
        .iter()
        .any(|(_, verbs)| verbs.contains(&word.as_str()));
    if !is_verb {
        return error;
    }
    let reason = format!(
        "this protomer was built without '{word}'; install it with its default features, among them \
         `learning`"
    );
    syntax.error(ErrorKind::InvalidSubcommand, reason)
}

/// The error for a word that is not a verb, with what may be meant: a file, for which the verb that takes
/// it is missing, or the second word of a verb of two words.
pub fn with_missing_verb(
    error: clap::Error,
    syntax: &mut Command,
    words: &[OsString],
) -> clap::Error {
    let Some(ContextValue::String(word)) = error.get(ContextKind::InvalidSubcommand) else {
        return error;
    };
    let words = words.iter().map(|word| word.to_string_lossy());
    let before: Vec<_> = words.take_while(|other| other != word).collect();
    let in_assemble = before.iter().any(|other| other == "assemble");
    let reason = match FileKind::from_path(Path::new(word)) {
        Some(FileKind::Body) if in_assemble => format!(
            "{word} is a body: 'protomer assemble ring {word}' and 'assemble fluid {word}' make assemblies of \
             bodies"
        ),
        _ if in_assemble && is_structure_or_entry(word) => format!(
            "{word} is not a way to assemble; for a structure, write 'protomer assemble structure {word}'"
        ),
        Some(FileKind::Structure | FileKind::Pqr) => format!(
            "{word} is a structure, and the verb is missing; 'protomer ingest {word}' makes a body of it, \
             'protomer assemble structure {word}' an assembly"
        ),
        _ => match verbs_with(syntax, word) {
            verbs if verbs.is_empty() => return error,
            verbs => format!("'{word}' alone is no verb; write {}", verbs.join(" or ")),
        },
    };
    syntax.error(ErrorKind::InvalidSubcommand, reason)
}

fn is_structure_or_entry(word: &str) -> bool {
    Format::of_name(word).is_some() || is_pdb_entry(word) || Path::new(word).is_file()
}

/// The commands of two words that end with this one, in quotes.
fn verbs_with(syntax: &Command, word: &str) -> Vec<String> {
    let mut found = Vec::new();
    for verb in syntax.get_subcommands() {
        if verb.get_name() != "help" && verb.find_subcommand(word).is_some() {
            found.push(format!("'protomer {} {word}'", verb.get_name()));
        }
    }
    found
}

#[cfg(test)]
mod tests {
    use super::*;
    use crate::Cli;
    use clap::CommandFactory;

    #[test]
    fn every_verb_stands_in_one_group_and_has_examples() {
        let command = Cli::command();
        let mut verbs: Vec<&str> = command.get_subcommands().map(Command::get_name).collect();
        let with_examples: Vec<&str> = EXAMPLES.iter().map(|(verb, _)| *verb).collect();
        for verb in &verbs {
            assert!(with_examples.contains(verb), "{verb} has no examples");
        }
        let mut listed: Vec<&str> = GROUPS
            .iter()
            .flat_map(|(_, verbs)| *verbs)
            .copied()
            .collect();
        verbs.push("help");
        verbs.sort_unstable();
        listed.sort_unstable();
        assert_eq!(listed, verbs);
    }

    #[test]
    fn examples_are_commands_of_their_verb() {
        for (verb, examples) in EXAMPLES {
            for example in examples {
                assert!(example == verb || example.starts_with(&format!("{verb} ")));
                let words = ["protomer"].into_iter().chain(example.split(' '));
                let parsed = completed(Cli::command()).try_get_matches_from(words);
                assert!(parsed.is_ok(), "{example}: {}", parsed.unwrap_err());
            }
        }
    }

    #[test]
    fn the_list_shows_the_beginning_of_a_description() {
        assert_eq!(
            beginning("Inspect an assembly: overlaps"),
            "Inspect an assembly"
        );
        assert_eq!(beginning("Draw. More"), "Draw");
        assert_eq!(beginning("Print completions"), "Print completions");
    }
}

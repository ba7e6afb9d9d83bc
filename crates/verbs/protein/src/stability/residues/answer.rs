//! The answer in words and as a figure.

use super::mutations::FEWEST_EFFECTIVE_FRAMES;
use super::result::{MutationRow, PairRow, ResidueRow, ResiduesResult, SharedBy};
use protomer_common::answer::{Answer, columns};
use protomer_mc::contributions::Mean;
use protomer_plot::{Axis, Figure, Panel, Point, Series, literal};

/// Number of rows in the table of residues.
const RESIDUES: usize = 12;
/// Number of rows in the table of pairs.
const PAIRS: usize = 8;
/// Number of exchanges in each direction in their table.
const MUTATIONS: usize = 6;

impl Answer for ResiduesResult {
    fn text(&self) -> String {
        let mut lines = vec![self.heading(), self.energy_line(), String::new()];
        let (by_residue, by_pair) = (self.residue_table(), self.pair_table());
        lines.push(by_residue);
        lines.push(String::new());
        lines.extend(by_pair);
        lines.push(self.outside_line());
        lines.extend(self.charges_note.as_deref().map(str::to_owned));
        if let Some(mutations) = &self.mutations {
            lines.push(String::new());
            lines.extend(self.mutation_lines(mutations));
            lines.extend(self.mutations_note.as_deref().map(str::to_owned));
        }
        lines.join("\n")
    }

    /// The energy of each residue along the chains of each body.
    fn figure(&self) -> Option<Figure> {
        let mut series: Vec<Series> = Vec::new();
        let mut names: Vec<&str> = Vec::new();
        for row in &self.residues {
            let place = names.iter().position(|name| *name == row.name.body);
            let index = place.unwrap_or(names.len());
            if place.is_none() {
                names.push(&row.name.body);
                series.push(Series {
                    name: literal(&row.name.body),
                    line: true,
                    ..Series::default()
                });
            }
            let points = &mut series[index].points;
            points.push(Point {
                x: points.len() as f64 + 1.0,
                y: row.energy_kt.mean,
                error: None,
            });
        }
        Some(Figure {
            title: "Energy by residue".into(),
            caption: self.conditions(),
            x: Axis::linear("residue, counted along the body"),
            panels: vec![Panel {
                y: Axis::linear("energy per copy (kT)"),
                series,
            }],
        })
    }
}

impl ResiduesResult {
    /// The salt and the frames in words.
    pub(super) fn conditions(&self) -> String {
        let salt = match self.interaction.electrolyte.salt_molar() {
            Some(salt) => format!("{} mM salt", rounded(1e3 * salt)),
            None => format!(
                "Debye length {:.2} Å",
                self.interaction.electrolyte.debye_length_angstrom()
            ),
        };
        match self.frames {
            1 if self.frames_read == 1 => format!("{salt}, one pose"),
            frames if self.bound_frames_only => format!(
                "{salt}, {frames} of {} frames of {}: those in which more than half of the contacts are \
                 left, because the sweep is not equilibrated",
                self.frames_read,
                counted(self.replicas, "replica")
            ),
            frames => format!(
                "{salt}, {frames} frames of {}",
                counted(self.replicas, "replica")
            ),
        }
    }

    fn heading(&self) -> String {
        let heading = format!("{} bodies at {}", self.bodies, self.conditions());
        match self.salt_chosen.as_deref() {
            Some(why) => format!("{heading}\n{why}; --salt chooses another"),
            None => heading,
        }
    }

    fn energy_line(&self) -> String {
        let mut line = match self.effective_energy_kt {
            None => "energy: ".to_owned(),
            Some(energy_kt) => format!(
                "energy of the run: {energy_kt:.2} kT\n{}",
                match self.shared_by {
                    SharedBy::PlainCharges => {
                        "energy with the plain charges, which is shared out: "
                    }
                    SharedBy::Charges => "energy that is shared out: ",
                }
            ),
        };
        line += &format!("{} kT", with_error(&self.energy.total_kt, 2));
        let terms = self.further_terms();
        if !terms.is_empty() {
            line += &format!(": charges {}", with_error(&self.energy.parts.charges_kt, 2));
        }
        for (term, energy_kt) in &terms {
            line += &format!(", {} {}", term.word(), with_error(energy_kt, 2));
        }
        line
    }

    fn residue_table(&self) -> String {
        let terms = self.further_terms();
        let mut heading = vec!["residue".to_owned(), "energy per copy (kT)".into()];
        if !terms.is_empty() {
            heading.push("charges".into());
        }
        heading.extend(terms.iter().map(|(term, _)| term.word().to_owned()));
        heading.extend(["touching", "surface (Å²)", "most with"].map(str::to_owned));
        let mut rows = vec![heading];
        for row in self.strongest().into_iter().take(RESIDUES) {
            let mut cells = vec![row.name.full(), with_error(&row.energy_kt, 2)];
            if !terms.is_empty() {
                cells.push(format!("{:.2}", row.parts.charges_kt));
            }
            for (term, _) in &terms {
                cells.push(format!("{:.2}", row.parts.part_kt(*term)));
            }
            cells.push(format!("{:.2}", row.touching));
            cells.push(match row.buried {
                true => format!("{:.0}, buried", row.surface_angstrom2),
                false => format!("{:.0}", row.surface_angstrom2),
            });
            cells.push(self.most_with(row).unwrap_or_default());
            rows.push(cells);
        }
        columns(&rows)
    }

    /// The partner with the largest energy of the same sign.
    fn most_with(&self, row: &ResidueRow) -> Option<String> {
        let sign = row.energy_kt.mean.signum();
        let mut most: Option<(&PairRow, bool)> = None;
        for pair in &self.pairs {
            let is_first = pair.first == row.name;
            let size = |pair: &PairRow| sign * pair.energy_kt.mean;
            let is_larger = most.is_none_or(|(partner, _)| size(pair) > size(partner));
            if (is_first || pair.second == row.name) && is_larger {
                most = Some((pair, is_first));
            }
        }
        most.map(|(pair, is_first)| match is_first {
            true => pair.second.full(),
            false => pair.first.full(),
        })
    }

    fn pair_table(&self) -> Vec<String> {
        let mut rows = vec![
            ["pair", "", "energy of all such pairs (kT)", "touching"]
                .map(str::to_owned)
                .to_vec(),
        ];
        let size = |pair: &PairRow| pair.energy_kt.mean.abs();
        let mut pairs: Vec<&PairRow> = self.pairs.iter().collect();
        pairs.sort_by(|a, b| size(b).total_cmp(&size(a)));
        for pair in pairs.into_iter().take(PAIRS) {
            rows.push(vec![
                pair.first.full(),
                pair.second.full(),
                with_error(&pair.energy_kt, 2),
                format!("{:.2}", pair.touching),
            ]);
        }
        match rows.len() {
            1 => vec!["no pair of residues has 0.01 kT".into(), String::new()],
            _ => vec![columns(&rows), String::new()],
        }
    }

    fn mutation_lines(&self, mutations: &[MutationRow]) -> Vec<String> {
        if mutations.is_empty() {
            return vec!["no residue on the surface can be exchanged".into()];
        }
        let mut listed: Vec<&MutationRow> = mutations.iter().collect();
        if !self.recommends_touching {
            listed.retain(|row| row.recommended);
        }
        let mut lines = match listed.is_empty() {
            true => Vec::new(),
            false => mutation_tables(&listed),
        };
        let left_out = mutations.len() - listed.len();
        if left_out > 0 {
            lines.push(format!(
                "{left_out} of {} exchanges are left out, because their residues touch another body: the scan \
                 knows the change of the charge and not that of the contact; --include-touching lists them",
                mutations.len()
            ));
        }
        lines
    }

    fn outside_line(&self) -> String {
        let untouched = percent(&self.residues_outside_contacts);
        let distance = self.touching_angstrom;
        let share = match &self.outside_contacts_share {
            Some(share) => format!(
                "of the energy of the charges {} comes from them",
                percent(share)
            ),
            None => {
                "the charges do not hold the bodies together, so there is no share of them".into()
            }
        };
        format!(
            "{untouched} of the residues touch no other body (no heavy atom within {distance} Å); {share}"
        )
    }
}

fn mutation_tables(mutations: &[&MutationRow]) -> Vec<String> {
    let (raising, lowering) = (
        mutations.iter().take(MUTATIONS),
        mutations.iter().rev().take(MUTATIONS),
    );
    let mut lines = vec![
        "exchanges of one charge in every copy that hold the bodies together most:".into(),
        mutation_table(raising.copied()),
        "and least:".into(),
        mutation_table(lowering.copied()),
    ];
    let has_salts = mutations.iter().any(|row| row.half_salt_molar.is_some());
    let unknown = mutations.iter().filter(|row| row.half_salt_molar.is_none());
    if has_salts && unknown.clone().count() > 0 {
        lines.push(format!(
            "{} of {} half salts are not known: fewer than {FEWEST_EFFECTIVE_FRAMES} effective frames, \
             or not between two salts of the sweep",
            unknown.count(),
            mutations.len()
        ));
    }
    lines
}

fn mutation_table<'a>(mutations: impl Iterator<Item = &'a MutationRow>) -> String {
    let mut rows = vec![
        [
            "body",
            "exchange",
            "charge (e)",
            "touching",
            "energy (kT)",
            "first order (mM)",
            "half salt (mM)",
            "shift (mM)",
            "effective frames",
        ]
        .map(str::to_owned)
        .to_vec(),
    ];
    for row in mutations {
        let millimolar = |mean: &Mean| {
            let scaled = Mean {
                mean: 1e3 * mean.mean,
                error: mean.error.map(|error| 1e3 * error),
            };
            signed(&scaled)
        };
        rows.push(vec![
            row.name.body.clone(),
            row.mutation.clone(),
            format!("{:+.2}", row.charge_change_e),
            format!("{:.2}", row.touching),
            signed(&row.energy_change_kt),
            row.first_order_half_salt_molar
                .map_or_else(|| "-".into(), |salt| rounded(1e3 * salt)),
            row.half_salt_molar
                .map_or_else(|| "-".into(), |salt| rounded(1e3 * salt)),
            row.half_salt_shift_molar
                .as_ref()
                .map_or_else(|| "-".into(), millimolar),
            format!("{:.0}", row.effective_frames),
        ]);
    }
    columns(&rows)
}

fn with_error(mean: &Mean, digits: usize) -> String {
    match mean.error {
        Some(error) => format!("{:.digits$} ± {error:.digits$}", mean.mean),
        None => format!("{:.digits$}", mean.mean),
    }
}

fn signed(mean: &Mean) -> String {
    match mean.error {
        Some(error) => format!("{:+.1} ± {error:.1}", mean.mean),
        None => format!("{:+.1}", mean.mean),
    }
}

fn percent(share: &Mean) -> String {
    match share.error {
        Some(error) => format!("{:.0} ± {:.0} %", 100.0 * share.mean, 100.0 * error),
        None => format!("{:.0} %", 100.0 * share.mean),
    }
}

fn rounded(number: f64) -> String {
    let digits = (2.0 - number.abs().max(1e-6).log10().floor()).clamp(0.0, 6.0) as usize;
    let text = format!("{number:.digits$}");
    match text.contains('.') {
        true => text.trim_end_matches('0').trim_end_matches('.').to_owned(),
        false => text,
    }
}

fn counted(number: usize, noun: &str) -> String {
    match number {
        1 => format!("one {noun}"),
        _ => format!("{number} {noun}s"),
    }
}

//! Contacts and energies of pairs of residues as maps: the two bodies between which most of the
//! energy is, with the residues that matter most.

use super::result::{PairRow, ResidueName, ResiduesResult};
use protomer_plot::{ColourMap, literal};

/// Rows and columns of a map.
const MOST: usize = 16;

/// Map of the pairs of residues that touch, with the share of the frames in which they do. `None`
/// if none does.
pub fn contact_map(result: &ResiduesResult) -> Option<ColourMap> {
    map(
        result,
        |pair| pair.touching,
        |pair| pair.contacts,
        Names {
            title: "Contacts",
            quantity: "share of frames in which they touch",
        },
    )
}

/// The energies of pairs of residues. `None` if there are none.
pub fn energy_map(result: &ResiduesResult) -> Option<ColourMap> {
    let energy = |pair: &PairRow| pair.energy_kt.mean;
    map(
        result,
        energy,
        |pair| pair.energy_kt.mean.abs(),
        Names {
            title: "Energies of pairs of residues",
            quantity: "energy of all such pairs (kT)",
        },
    )
}

struct Names {
    title: &'static str,
    quantity: &'static str,
}

fn map(
    result: &ResiduesResult,
    value: impl Fn(&PairRow) -> f64,
    weight: impl Fn(&PairRow) -> f64,
    names: Names,
) -> Option<ColourMap> {
    let (first, second) = most_between(&result.pairs, &weight)?;
    let is_of = |pair: &&PairRow| pair.first.body == first && pair.second.body == second;
    let mut pairs: Vec<&PairRow> = result.pairs.iter().filter(is_of).collect();
    pairs.retain(|pair| weight(pair) > 0.0);
    let is_one_body = first == second;
    // A pair of one body with itself stands on both sides of the diagonal.
    let mut ends: Vec<(&ResidueName, &ResidueName, &PairRow)> = Vec::new();
    for pair in &pairs {
        ends.push((&pair.first, &pair.second, pair));
        if is_one_body && pair.first != pair.second {
            ends.push((&pair.second, &pair.first, pair));
        }
    }
    let rows = strongest(ends.iter().map(|(row, _, pair)| (*row, weight(pair))));
    let columns = strongest(ends.iter().map(|(_, column, pair)| (*column, weight(pair))));
    let mut values = Vec::with_capacity(rows.len() * columns.len());
    for row in &rows {
        for column in &columns {
            // A pair that never touched is zero, not unknown.
            let entry = ends.iter().find(|(a, b, _)| a == row && b == column);
            values.push(Some(entry.map_or(0.0, |(_, _, pair)| value(pair))));
        }
    }
    Some(ColourMap {
        title: format!(
            "{} of {} and {}",
            names.title,
            literal(&first),
            literal(&second)
        ),
        caption: result.conditions(),
        x: literal(&second),
        columns: labels(&columns),
        y: literal(&first),
        rows: labels(&rows),
        quantity: names.quantity.into(),
        values,
    })
}

/// Short names, without the chain if there is one only.
fn labels(names: &[&ResidueName]) -> Vec<String> {
    let is_one_chain = names.windows(2).all(|pair| pair[0].chain == pair[1].chain);
    let mut labels = Vec::with_capacity(names.len());
    for name in names {
        let short = name.short();
        let chain = format!("{}:", name.chain);
        let without = short.strip_prefix(&chain).filter(|_| is_one_chain);
        labels.push(without.unwrap_or(&short).to_owned());
    }
    labels
}

/// The two bodies whose pairs weigh most together.
fn most_between(pairs: &[PairRow], weight: impl Fn(&PairRow) -> f64) -> Option<(String, String)> {
    let mut sums: Vec<((&str, &str), f64)> = Vec::new();
    for pair in pairs {
        let bodies = (pair.first.body.as_str(), pair.second.body.as_str());
        match sums.iter_mut().find(|(key, _)| *key == bodies) {
            Some((_, sum)) => *sum += weight(pair),
            None => sums.push((bodies, weight(pair))),
        }
    }
    let most = sums.iter().max_by(|a, b| a.1.total_cmp(&b.1));
    let most = most.filter(|(_, sum)| *sum > 0.0);
    most.map(|((first, second), _)| ((*first).to_owned(), (*second).to_owned()))
}

/// The names with the largest sums of weights, in the order of the chain.
fn strongest<'a>(weights: impl Iterator<Item = (&'a ResidueName, f64)>) -> Vec<&'a ResidueName> {
    let mut sums: Vec<(&ResidueName, f64)> = Vec::new();
    for (name, weight) in weights {
        match sums.iter_mut().find(|(key, _)| *key == name) {
            Some((_, sum)) => *sum += weight,
            None => sums.push((name, weight)),
        }
    }
    sums.sort_by(|a, b| b.1.total_cmp(&a.1));
    sums.truncate(MOST);
    // In the order of the chain, as a reader looks for them.
    let place = |name: &ResidueName| (name.chain.clone(), name.number, name.insertion_code.clone());
    sums.sort_by_key(|(name, _)| place(name));
    sums.into_iter().map(|(name, _)| name).collect()
}

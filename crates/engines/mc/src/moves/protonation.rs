//! Trial moves of the protons of one body.

use protomer_kernel::random::CounterRng;

/// Share of the moves that draw the forms of two groups of a body at once.
const DOUBLE_SHARE: f64 = 0.5;

/// The groups of a body in these states that change their forms. One or two groups are drawn, between which a proton may go
/// over, and a form for each of them, charged or neutral. Often none changes.
///
/// **Why this is exact.** Groups and forms are drawn without regard to the present ones, so the way back is as likely as the way
/// there, and the Metropolis rule satisfies detailed balance at constant pH. That a group may keep its form matters: if every move
/// changed one, all would be accepted where both forms are equal, and an even number of them would lead back each time.
pub fn propose(states: &[bool], rng: &mut CounterRng) -> Vec<usize> {
    let groups = states.len();
    if groups == 0 {
        return Vec::new();
    }
    let mut drawn = vec![rng.index(groups)];
    if groups > 1 && rng.uniform() < DOUBLE_SHARE {
        // One of the others, each equally likely.
        drawn.push((drawn[0] + 1 + rng.index(groups - 1)) % groups);
    }
    drawn.retain(|group| (rng.uniform() < 0.5) != states[*group]);
    drawn
}

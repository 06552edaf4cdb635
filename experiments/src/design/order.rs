//! The combinatorics of a design: rounds, directions, Latin squares.

use crate::random::Stream;
use indexmap::IndexMap;
use shutterlab_data_schema::protocol::Pairs;
use shutterlab_data_schema::response::Side;

/// The pairs a < b that `pairs` asks for, in rounds in which no stimulus comes twice.
///
/// Stimuli that are all compared with one another make their rounds as in a tournament: one stays, the
/// others move round a circle (Kirkman 1847). With one-axis pairs these are the stimuli that agree in
/// every other axis, and the rounds of all such groups of an axis are held at once.
pub(super) fn rounds(
    levels: &[IndexMap<String, String>],
    pairs: Pairs,
) -> Vec<Vec<(usize, usize)>> {
    let all: Vec<usize> = (0..levels.len()).collect();
    if pairs != Pairs::OneAxis {
        return tournament(&all);
    }
    let mut rounds = Vec::new();
    for axis in levels.first().map_or(vec![], |levels| levels.keys().collect()) {
        let mut groups: IndexMap<Vec<&String>, Vec<usize>> = IndexMap::new();
        for (index, levels) in levels.iter().enumerate() {
            let others = levels.iter().filter(|(other, _)| *other != axis);
            groups.entry(others.map(|(_, level)| level).collect()).or_default().push(index);
        }
        let mut of_axis: Vec<Vec<(usize, usize)>> = Vec::new();
        for group in groups.values() {
            for (number, round) in tournament(group).into_iter().enumerate() {
                match of_axis.get_mut(number) {
                    Some(there) => there.extend(round),
                    None => of_axis.push(round),
                }
            }
        }
        rounds.extend(of_axis);
    }
    rounds
}

/// Every pair of `members` once, in rounds in which no member comes twice.
fn tournament(members: &[usize]) -> Vec<Vec<(usize, usize)>> {
    let seats = members.len() + members.len() % 2;
    (0..seats.saturating_sub(1))
        .map(|round| {
            (0..seats / 2)
                .filter_map(|table| {
                    // Seat 0 stays, the others move on by one; an empty seat rests its partner.
                    let seat = |place: usize| match place {
                        0 => 0,
                        place => 1 + (place - 1 + round) % (seats - 1),
                    };
                    let one = members.get(seat(table))?;
                    let other = members.get(seat(seats - 1 - table))?;
                    Some((*one.min(other), *one.max(other)))
                })
                .collect()
        })
        .collect()
}

/// A direction for each pair of 0..n: every one is first as often as second, or once more or less if
/// it is in an odd number of pairs. The pairs are walked through in closed walks by chance; those in
/// an odd number of pairs meet in an extra place.
pub(super) fn orient(pairs: &[(usize, usize)], n: usize, stream: &mut Stream) -> Vec<Side> {
    let mut ways: Vec<Vec<(usize, usize)>> = vec![vec![]; n + 1];
    let mut count = 0;
    let mut connect = |a: usize, b: usize, ways: &mut Vec<Vec<(usize, usize)>>| {
        ways[a].push((b, count));
        ways[b].push((a, count));
        count += 1;
    };
    for &(a, b) in pairs {
        connect(a, b, &mut ways);
    }
    for place in 0..n {
        if ways[place].len() % 2 == 1 {
            connect(place, n, &mut ways);
        }
    }
    for way in &mut ways {
        stream.shuffle(way);
    }
    let mut starts: Vec<usize> = (0..=n).collect();
    stream.shuffle(&mut starts);
    let mut walked: Vec<Option<usize>> = vec![None; count];
    for start in starts {
        let mut here = start;
        while let Some((there, edge)) = ways[here].pop() {
            if walked[edge].is_none() {
                walked[edge] = Some(here);
                here = there;
            }
        }
    }
    let named = |(&(a, _), from): (&(usize, usize), &Option<usize>)| {
        if *from == Some(a) { Side::A } else { Side::B }
    };
    pairs.iter().zip(&walked).map(named).collect()
}

/// As many `true` as `false`, or one more of either, in random order.
pub(super) fn balanced_flags(count: usize, stream: &mut Stream) -> Vec<bool> {
    let odd = stream.below(2);
    let mut flags: Vec<bool> = (0..count).map(|index| (index + odd).is_multiple_of(2)).collect();
    stream.shuffle(&mut flags);
    flags
}

/// Row number `row` of a Latin square of `n` conditions that is balanced for carry-over (Williams
/// 1949): n rows for even n, 2n for odd.
pub(super) fn williams_row(n: usize, row: usize) -> Vec<usize> {
    if n == 0 {
        return vec![];
    }
    let zigzag = (0..n).map(|k| if k % 2 == 1 { k.div_ceil(2) } else { (n - k / 2) % n });
    let mut order: Vec<usize> = zigzag.map(|k| (k + row) % n).collect();
    if n % 2 == 1 && (row / n) % 2 == 1 {
        order.reverse();
    }
    order
}

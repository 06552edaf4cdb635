//! Whether scale values exist: do the comparisons hang together, and was each group of items both
//! chosen over and rejected for the rest (Ford 1957)?

use super::comparisons::Comparisons;
use crate::outcome::Outcome;

/// The parts of the items that no comparison connects, each in ascending order.
fn unconnected_parts(comparisons: &Comparisons) -> Vec<Vec<usize>> {
    let mut edges = vec![Vec::new(); comparisons.items().len()];
    for pair in comparisons.pairs() {
        edges[pair.i].push(pair.j);
        edges[pair.j].push(pair.i);
    }
    strong_components(&edges)
}

/// The groups of items in an order in which no item was ever chosen over one of an earlier group, each
/// group as small as possible. Maximum-likelihood scale values are finite if and only if there is one
/// group alone (Ford 1957). A tie is half a win for each.
fn groups_never_beaten_from_below(comparisons: &Comparisons) -> Vec<Vec<usize>> {
    let mut edges = vec![Vec::new(); comparisons.items().len()];
    for pair in comparisons.pairs() {
        let [i_wins, j_wins] = pair.wins_and_half_ties();
        if i_wins > 0.0 {
            edges[pair.i].push(pair.j);
        }
        if j_wins > 0.0 {
            edges[pair.j].push(pair.i);
        }
    }
    strong_components(&edges)
}

/// Refuses comparisons that give no scale at all.
///
/// # Errors
/// In words: nothing was compared, or which items were never compared with which.
pub fn check_connected(comparisons: &Comparisons) -> Outcome<()> {
    if comparisons.pairs().is_empty() {
        return Err("there is no answer to any pair".into());
    }
    let parts = unconnected_parts(comparisons);
    if parts.len() == 1 {
        return Ok(());
    }
    Err(format!(
        "the comparisons fall into {} parts without a pair between them ({}), and values of different parts have no common scale",
        parts.len(),
        in_braces(&parts, comparisons.items(), ", ")
    ))
}

/// Why there are no finite maximum-likelihood scale values, or nothing.
pub fn separation(comparisons: &Comparisons) -> Option<String> {
    let items = comparisons.items();
    let groups = groups_never_beaten_from_below(comparisons);
    if groups.len() == 1 {
        return None;
    }
    let ends =
        [(&groups[0], "was never rejected"), (&groups[groups.len() - 1], "was never chosen")];
    let single: Vec<String> = ends
        .iter()
        .filter(|(group, _)| group.len() == 1)
        .map(|(group, said)| format!("{} {said}", items[group[0]]))
        .collect();
    let single = if single.is_empty() { String::new() } else { format!("{}: ", single.join(", ")) };
    Some(format!(
        "{single}in {} no item was ever chosen over one of an earlier group, so the likelihood grows without end as the groups move apart",
        in_braces(&groups, items, " > ")
    ))
}

fn in_braces(groups: &[Vec<usize>], items: &[String], between: &str) -> String {
    let names = |group: &Vec<usize>| group.iter().map(|i| items[*i].as_str()).collect::<Vec<_>>();
    let groups: Vec<String> =
        groups.iter().map(|g| format!("{{{}}}", names(g).join(", "))).collect();
    groups.join(between)
}

/// The strongly connected components of a directed graph in an order in which no edge leads back to an
/// earlier one (Kosaraju's algorithm: depth first, then depth first against the edges).
fn strong_components(edges: &[Vec<usize>]) -> Vec<Vec<usize>> {
    let mut against = vec![Vec::new(); edges.len()];
    for (from, to) in edges.iter().enumerate().flat_map(|(i, to)| to.iter().map(move |j| (i, *j))) {
        against[to].push(from);
    }
    let mut finished = Vec::new();
    let mut seen = vec![false; edges.len()];
    (0..edges.len()).for_each(|start| depth_first(edges, start, &mut seen, &mut finished));
    seen.fill(false);
    let mut components = Vec::new();
    for start in finished.into_iter().rev() {
        let mut component = Vec::new();
        depth_first(&against, start, &mut seen, &mut component);
        if !component.is_empty() {
            component.sort_unstable();
            components.push(component);
        }
    }
    components
}

/// Appends what can be reached from `start` and was not `seen` to `finished`, in the order in which a
/// search has left it.
fn depth_first(edges: &[Vec<usize>], start: usize, seen: &mut [bool], finished: &mut Vec<usize>) {
    if std::mem::replace(&mut seen[start], true) {
        return;
    }
    // Each item on the way with the number of its edges that were tried.
    let mut way = vec![(start, 0)];
    while let Some((from, tried)) = way.last_mut() {
        match edges[*from].get(*tried) {
            Some(to) => {
                *tried += 1;
                if !std::mem::replace(&mut seen[*to], true) {
                    way.push((*to, 0));
                }
            }
            None => {
                finished.push(*from);
                way.pop();
            }
        }
    }
}

#[cfg(test)]
mod tests {
    use super::*;

    fn of(wins: [[f64; 4]; 4]) -> Comparisons {
        let items = ["a", "b", "c", "d"].map(String::from);
        Comparisons::of_matrix(&items, &wins.map(|row| row.to_vec())).unwrap()
    }

    #[test]
    fn parts_are_named() {
        let wins = of([[0., 1., 0., 0.], [2., 0., 0., 0.], [0., 0., 0., 1.], [0., 0., 0., 0.]]);
        let error = check_connected(&wins).unwrap_err();
        assert!(error.contains("2 parts without a pair between them ("), "{error}");
        assert!(error.contains("{a, b}") && error.contains("{c, d}"), "{error}");
        assert!(check_connected(&of([[0.0; 4]; 4])).unwrap_err().contains("no answer"));
    }

    #[test]
    fn separated_groups_are_named_in_their_order() {
        let wins = of([[0., 0., 0., 1.], [5., 0., 2., 3.], [4., 0., 0., 3.], [1., 0., 0., 0.]]);
        let said = separation(&wins).unwrap();
        assert!(said.starts_with("b was never rejected: in {b} > {c} > {a, d} no item"), "{said}");
        let wins = of([[0., 1., 1., 1.], [1., 0., 2., 3.], [4., 1., 0., 0.], [1., 0., 0., 0.]]);
        assert_eq!(separation(&wins), None);
    }
}

//! Sets of nodes or elements: lists, ranges, and other sets by name.

use super::cards::{Card, Cards, Data};
use crate::mesh::MeshError;
use rustc_hash::FxHashMap;

/// Ids, not expanded: `GENERATE` may name billions.
#[derive(Debug, Clone, Default)]
pub(super) struct Set {
    ranges: Vec<Range>,
    /// Indices of other sets.
    sets: Vec<usize>,
}

/// Every `step`-th id from `first` to `last`.
#[derive(Debug, Clone, Copy)]
struct Range {
    first: u32,
    last: u32,
    step: u32,
}

impl Set {
    pub(super) fn push(&mut self, id: u32) {
        match self.ranges.last_mut() {
            Some(range) if range.step == 1 && range.last.checked_add(1) == Some(id) => range.last = id,
            _ => self.ranges.push(Range { first: id, last: id, step: 1 }),
        }
    }

    pub(super) fn extend(&mut self, other: &Self) {
        self.ranges.extend(&other.ranges);
        self.sets.extend(&other.sets);
    }
}

/// Sets by name, in the order of the file.
#[derive(Default)]
pub(super) struct Sets {
    /// The name, whether `*ELEMENT` defined it (not a card of its own), and the set.
    sets: Vec<(String, bool, Set)>,
    by_name: FxHashMap<String, usize>,
}

impl Sets {
    /// Adds to the set of that name, or makes it. Names differ in more than their capitals.
    pub(super) fn add(&mut self, name: &str, set: Set) {
        self.insert(name, false, &set);
    }

    /// Adds what a card of elements puts into a set.
    pub(super) fn add_block(&mut self, name: &str, set: Set) {
        self.insert(name, true, &set);
    }

    fn insert(&mut self, name: &str, block: bool, set: &Set) {
        let index = *self.by_name.entry(name.to_ascii_uppercase()).or_insert_with(|| {
            self.sets.push((name.to_owned(), block, Set::default()));
            self.sets.len() - 1
        });
        self.sets[index].2.extend(set);
    }

    /// Names, whether elements' cards defined them, and indices.
    pub(super) fn iter(&self) -> impl Iterator<Item = (&str, bool, usize)> {
        self.sets.iter().enumerate().map(|(i, (name, block, _))| (name.as_str(), *block, i))
    }

    /// The set of that name. A name may have that of an instance before it, `instance.set`.
    pub(super) fn find(&self, name: &str) -> Option<usize> {
        let name = name.to_ascii_uppercase();
        let last = name.rsplit('.').next().unwrap_or("");
        self.by_name.get(&name).or_else(|| self.by_name.get(last)).copied()
    }

    /// The next field as an id or the name of a set.
    pub(super) fn parse(&self, data: &mut Data) -> Result<Set, MeshError> {
        let word = data.word();
        let mut set = Set::default();
        if let Ok(id) = word.rsplit('.').next().unwrap_or("").parse() {
            set.push(id);
        } else {
            let shown: String = word.chars().take(40).collect();
            set.sets.push(self.find(word).ok_or_else(|| {
                data.error(format!("there is no set {shown:?} above this line"), "define it before it is used")
            })?);
        }
        Ok(set)
    }

    /// Shows `visit` those of the `known` ids (ascending) that a set holds, some of them more than once.
    pub(super) fn members(&self, set: &Set, known: &[u32], mut visit: impl FnMut(u32)) {
        let mut seen = vec![false; self.sets.len()];
        let mut open = vec![set];
        while let Some(set) = open.pop() {
            for &Range { first, last, step } in &set.ranges {
                let begin = known.partition_point(|&id| id < first);
                let inside = known[begin..].iter().take_while(|&&id| id <= last);
                inside.filter(|&&id| (id - first) % step == 0).for_each(|&id| visit(id));
            }
            for &i in &set.sets {
                if !std::mem::replace(&mut seen[i], true) {
                    open.push(&self.sets[i].2);
                }
            }
        }
    }

    /// The set of an index.
    pub(super) fn get(&self, index: usize) -> &Set {
        &self.sets[index].2
    }
}

/// Reads the data of an `*NSET` or `*ELSET` card.
pub(super) fn read(card: &Card, cards: &mut Cards, kind: &str, sets: &mut Sets) -> Result<(), MeshError> {
    let name = card.value(kind)?;
    let generate = card.find("GENERATE").is_some();
    let mut set = Set::default();
    while let Some(mut data) = cards.data() {
        if generate {
            set.ranges.push(range(&mut data)?);
        } else {
            while !data.is_empty() {
                set.extend(&sets.parse(&mut data)?);
            }
        }
    }
    sets.add(name, set);
    Ok(())
}

/// First and last id, and the step, 1 if it is left out.
fn range(data: &mut Data) -> Result<Range, MeshError> {
    let (first, last) = (data.id("the first id of the range")?, data.id("the last id of the range")?);
    let step = if data.is_empty() { 1 } else { data.id("the step of the range")? };
    if step == 0 || last < first {
        return Err(data.error(format!("no range: {first} to {last} by {step}"), "give first, last and step"));
    }
    Ok(Range { first, last, step })
}

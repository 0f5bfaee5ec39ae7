//! Long lists of regular whole numbers in little memory.

/// Whole numbers held as arithmetic progressions: ids that count up, places of entries of one size, tags of blocks.
#[derive(Debug, Default)]
pub(super) struct Runs {
    runs: Vec<Run>,
    len: usize,
}

/// A progression: the number at index `first` is `value`, each next one is larger by `step`.
#[derive(Debug, Clone, Copy)]
struct Run {
    first: usize,
    value: i64,
    step: i64,
}

impl Run {
    fn at(&self, index: usize) -> i64 {
        self.value.wrapping_add(self.step.wrapping_mul((index - self.first) as i64))
    }
}

impl Runs {
    pub(super) fn push(&mut self, value: i64) {
        let len = self.len;
        self.len += 1;
        if let Some(last) = self.runs.last_mut() {
            if last.first + 1 == len {
                last.step = value.wrapping_sub(last.value);
                return;
            }
            if last.at(len) == value {
                return;
            }
        }
        self.runs.push(Run { first: len, value, step: 0 });
    }

    pub(super) fn len(&self) -> usize {
        self.len
    }

    /// The number at an index; 0 behind the end.
    pub(super) fn get(&self, index: usize) -> i64 {
        let run = self.runs.partition_point(|run| run.first <= index).checked_sub(1);
        run.filter(|_| index < self.len).map_or(0, |run| self.runs[run].at(index))
    }

    pub(super) fn iter(&self) -> impl Iterator<Item = i64> {
        let ends = self.runs.iter().skip(1).map(|run| run.first).chain([self.len]);
        self.runs.iter().zip(ends).flat_map(|(run, end)| (run.first..end).map(|index| run.at(index)))
    }
}

#[cfg(test)]
mod tests {
    use super::*;
    use proptest::prelude::*;

    proptest! {
        #[test]
        fn the_numbers_come_back(values in prop::collection::vec(prop_oneof![0..4_i64, any::<i64>()], 0..60)) {
            let mut runs = Runs::default();
            values.iter().for_each(|&v| runs.push(v));
            prop_assert_eq!(runs.iter().collect::<Vec<_>>(), values.clone());
            prop_assert!((0..values.len()).all(|i| runs.get(i) == values[i]));
            prop_assert_eq!(runs.len(), values.len());
        }
    }

    #[test]
    fn regular_lists_take_one_run_a_block() {
        let mut runs = Runs::default();
        (0..1000).for_each(|i| runs.push(40 * i + 7));
        (0..1000).for_each(|_| runs.push(3));
        assert!(runs.runs.len() <= 3, "{:?}", runs.runs);
    }
}

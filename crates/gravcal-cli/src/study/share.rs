//! Which share of a study a run does: one that is named, or that of a task of a Slurm array.

use gravcal_study::batch::Shard;

/// The K-th of N shares, from `K/N`.
pub fn named(text: &str) -> Result<Shard, String> {
    let numbers = text.split_once('/').and_then(|(k, n)| Some((k.parse().ok()?, n.parse().ok()?)));
    match numbers {
        Some((number, of)) if (1..=of).contains(&number) => Ok(Shard { number, of }),
        _ => Err("expected K/N with K from 1 to N, such as 1/4".to_owned()),
    }
}

/// The share of the task of a Slurm array in which the program runs; nothing outside of one.
pub fn of_slurm_task() -> Option<Shard> {
    of_task(|name| std::env::var(name).ok()?.parse().ok())
}

/// Slurm counts tasks from `MIN` on by `STEP`.
fn of_task(variable: impl Fn(&str) -> Option<usize>) -> Option<Shard> {
    let of = variable("SLURM_ARRAY_TASK_COUNT")?;
    let first = variable("SLURM_ARRAY_TASK_MIN").unwrap_or(0);
    let step = variable("SLURM_ARRAY_TASK_STEP").unwrap_or(1).max(1);
    let number = variable("SLURM_ARRAY_TASK_ID")?.checked_sub(first)? / step + 1;
    (number <= of).then_some(Shard { number, of })
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn shares_are_counted_from_one() {
        assert_eq!(named("2/4"), Ok(Shard { number: 2, of: 4 }));
        for wrong in ["0/4", "5/4", "1", "a/b", "1/0"] {
            assert!(named(wrong).is_err(), "{wrong}");
        }
    }

    fn task(values: &[(&str, usize)]) -> Option<Shard> {
        of_task(|name| values.iter().find(|(own, _)| *own == name).map(|(_, value)| *value))
    }

    #[test]
    fn a_task_of_an_array_has_its_share() {
        let (id, count, min) = ("SLURM_ARRAY_TASK_ID", "SLURM_ARRAY_TASK_COUNT", "SLURM_ARRAY_TASK_MIN");
        assert_eq!(task(&[(id, 0), (count, 3), (min, 0)]), Some(Shard { number: 1, of: 3 }));
        assert_eq!(task(&[(id, 7), (count, 3), (min, 5)]), Some(Shard { number: 3, of: 3 }));
        assert_eq!(task(&[(id, 14), (count, 3), (min, 10), ("SLURM_ARRAY_TASK_STEP", 2)]).unwrap().number, 3);
        assert_eq!(task(&[]), None);
        assert_eq!(task(&[(id, 9), (count, 3), (min, 0)]), None, "tasks that were left out cannot be counted");
    }
}

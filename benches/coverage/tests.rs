//! The same with fewer draws. What holds must be within four standard deviations of 95 %, what fails far below.

use gravcal_estimation::{Loss, LossName};

use crate::errors::{Errors, SAMPLES};
use crate::simulate::{Coverage, Method, Scenario, simulate};

const DRAWS: usize = 2_000;

fn coverage(errors: Errors, loss: Loss, method: Method) -> Coverage {
    simulate(Scenario { each: SAMPLES / 8, errors, loss, method }, DRAWS, &|| ()).unwrap()
}

#[track_caller]
fn assert_holds(coverage: Coverage) {
    let tolerance = 4.0 * coverage.noise();
    assert!(coverage.shares().iter().all(|share| (share - 0.95).abs() < tolerance), "{:?}", coverage.shares());
}

#[test]
fn intervals_from_the_noise_hold_where_the_noise_is_right() {
    assert_holds(coverage(Errors::Normal, Loss::None, Method::Stated));
    assert_holds(coverage(Errors::Normal, Loss::None, Method::Relative));
    assert_holds(coverage(Errors::Outliers, LossName::Huber.efficient(), Method::Stated));
}

#[test]
fn where_the_noise_is_wrong_blocks_hold_and_the_noise_fails() {
    for method in [Method::Stated, Method::Relative] {
        let plain = coverage(Errors::Shared, Loss::None, method);
        assert!(plain.shares().iter().all(|share| *share < 0.85), "{:?}", plain.shares());
    }
    assert_holds(coverage(Errors::Shared, Loss::None, Method::Sandwich));
    assert_holds(coverage(Errors::Unequal, Loss::None, Method::Sandwich));
}

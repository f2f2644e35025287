//! Ends of other starts that explain the readings better than the solution, or about as well: one list, one loop.
//!
//! Where few joints move, and little, a fit may end in a valley of its own beside the true one, and its χ² says nothing of that: both
//! explain the readings. So one starts again from what is known otherwise:
//!
//! | order | start | why then |
//! |---|---|---|
//! | 1 | position sensors as declared | how gravity points is told no better than the angles are |
//! | 2 | gravity as declared | only where the readings are explained: else there is another cause, which is looked for from there |
//! | 3 | a standing joint on the other side of a quarter turn, and the same with a joint beyond it turned back | it mirrors the end that the others leave, each such joint by itself |

use gravcal_identification::SolveEnvironment;
use gravcal_robot_model::session::Session;

use crate::joint::ends::mirrored_standing::mirrored_standing;
use crate::joint::ends::near_declared::{gravity_as_declared, positions_as_declared};
use crate::joint::ends::other_start::OtherStart;
use crate::joint::error::EstimateError;
use crate::joint::solved::Solved;

/// Other starts than that of a solution; none where nothing speaks for them.
type Starts = fn(&Solved, &Session, &SolveEnvironment<'_>) -> Result<Vec<OtherStart>, EstimateError>;

/// In the order in which they are tried, each beside the solution that those before it leave.
const OTHER_STARTS: [Starts; 3] = [positions_as_declared, gravity_as_declared, mirrored_standing];

/// The solution, or a likelier end of another start; what explains the readings about as well is kept beside it.
///
/// # Errors
/// Where an end cannot be judged.
pub(in crate::joint) fn or_other_end(
    solved: Solved,
    session: &Session,
    environment: &SolveEnvironment<'_>,
) -> Result<Solved, EstimateError> {
    if !solved.is_minimum_of_all() {
        return Ok(solved);
    }
    let mut best = solved;
    for starts in OTHER_STARTS {
        for start in starts(&best, session, environment)? {
            best = best.or_from(session, start, environment)?;
        }
    }
    Ok(best)
}

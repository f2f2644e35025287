//! What to look at besides where there are wrist sensors.

use gravcal_robot_model::session::Session;

/// One sentence, or nothing.
pub(super) fn of_instruments(session: &Session) -> &'static str {
    match session.instruments.is_empty() {
        true => "",
        false => {
            " Of a wrist sensor: its sign (sign = \"reversed\"), its mounting, the frame of its readings (frame), and whether it was zeroed \
             before each table (biases = \"table\")."
        }
    }
}

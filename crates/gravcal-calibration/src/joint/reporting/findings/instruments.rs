//! What to look at besides where there are wrist sensors or accelerometers.

use gravcal_robot_model::session::Session;

/// One sentence, or nothing.
pub(super) fn of_instruments(session: &Session) -> &'static str {
    match session.instruments.is_empty() {
        true => "",
        false => {
            " Of a wrist sensor or an accelerometer: its mounting (rpy_deg), its sign (sign = \"reversed\"), the frame of its readings (frame), and whether it was zeroed \
             before each table (biases = \"table\")."
        }
    }
}

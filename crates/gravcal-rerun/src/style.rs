//! Colours, the same for the same thing everywhere, and readable on light and dark.

use re_sdk_types::components::Color;

/// Before the calibration.
pub const NOMINAL: [u8; 3] = [204, 121, 167];
/// Readings.
pub const MEASURED: [u8; 3] = [150, 150, 150];
/// Frames and captions.
pub const FRAME: [u8; 3] = [128, 128, 128];
/// Bodies of links.
pub const LINK: [u8; 3] = [110, 120, 135];
/// Loads.
pub const LOAD: [u8; 3] = [213, 94, 0];
/// The pose that is shown.
pub const NOW: [u8; 3] = [240, 228, 66];

/// Those of Okabe and Ito, which the colour-blind can tell apart, and a grey.
const PALETTE: [[u8; 3]; 8] = [
    [86, 180, 233],
    [230, 159, 0],
    [0, 158, 115],
    [204, 121, 167],
    [213, 94, 0],
    [240, 228, 66],
    [0, 114, 178],
    [170, 170, 170],
];

/// Of an estimator or `nominal`.
pub fn of(name: &str) -> Color {
    let [r, g, b] = match name {
        "nominal" => NOMINAL,
        "joint" => PALETTE[0],
        "sequential" => PALETTE[1],
        _ => PALETTE[2],
    };
    Color::from_rgb(r, g, b)
}

/// Of the joint or channel of this number.
pub fn numbered(index: usize) -> Color {
    colour(PALETTE[index % PALETTE.len()])
}

/// As Rerun takes it.
pub fn colour([r, g, b]: [u8; 3]) -> Color {
    Color::from_rgb(r, g, b)
}

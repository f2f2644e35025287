//! Where else the truth may be than where a solve ended: images, other ends, values nearby at which readings say less.

pub(super) mod aligned;
pub(super) mod displaced;
pub(super) mod mirrored_standing;
pub(super) mod near_declared;
pub(super) mod nearby;
pub(super) mod profiles;
pub(super) mod resting;
pub(super) mod symmetries;

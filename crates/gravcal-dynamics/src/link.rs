//! A link: the rigid body that a joint moves.

/// What gravity sees of a rigid body.
#[derive(Clone, Copy, Debug, Default, PartialEq)]
pub struct LinkInertia {
    /// Mass, kg.
    pub mass: f64,
    /// Mass times centre of mass, in the link's frame, kg·m.
    pub first_moment: [f64; 3],
}

/// One body of a chain.
#[derive(Clone, Debug, PartialEq)]
pub struct Link {
    /// Name, unique in the chain and not the base's.
    pub name: String,
    /// Assumed value (from a drawing, a URDF, a data sheet); `None` where nothing is known.
    pub inertia: Option<LinkInertia>,
}

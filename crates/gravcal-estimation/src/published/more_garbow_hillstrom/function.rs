//! The 35 functions by their numbers in the paper.

use super::{fits, scalable, small};
use crate::Number;

/// A function of the collection, in the order of section 3 of the paper.
#[derive(Clone, Copy, Debug)]
pub(in crate::published) enum Function {
    Rosenbrock = 1,
    FreudensteinRoth,
    PowellBadlyScaled,
    BrownBadlyScaled,
    Beale,
    JennrichSampson,
    HelicalValley,
    Bard,
    Gaussian,
    Meyer,
    Gulf,
    Box3,
    PowellSingular,
    Wood,
    KowalikOsborne,
    BrownDennis,
    Osborne1,
    BiggsExp6,
    Osborne2,
    Watson,
    ExtendedRosenbrock,
    ExtendedPowellSingular,
    Penalty1,
    Penalty2,
    VariablyDimensioned,
    Trigonometric,
    BrownAlmostLinear,
    DiscreteBoundaryValue,
    DiscreteIntegralEquation,
    BroydenTridiagonal,
    BroydenBanded,
    LinearFullRank,
    LinearRankOne,
    LinearRankOneWithZeros,
    Chebyquad,
}

impl Function {
    /// Writes the rows `f_1, f_2, …` of the paper; how many rows and parameters there are is the slices'.
    pub(in crate::published) fn evaluate<N: Number>(self, x: &[N], f: &mut [N]) {
        match self {
            Function::Rosenbrock | Function::ExtendedRosenbrock => small::rosenbrock(x, f),
            Function::FreudensteinRoth => small::freudenstein_roth(x, f),
            Function::PowellBadlyScaled => small::powell_badly_scaled(x, f),
            Function::BrownBadlyScaled => small::brown_badly_scaled(x, f),
            Function::Beale => small::beale(x, f),
            Function::JennrichSampson => small::jennrich_sampson(x, f),
            Function::HelicalValley => small::helical_valley(x, f),
            Function::Bard => fits::bard(x, f),
            Function::Gaussian => fits::gaussian(x, f),
            Function::Meyer => fits::meyer(x, f),
            Function::Gulf => fits::gulf(x, f),
            Function::Box3 => small::box_three(x, f),
            Function::PowellSingular | Function::ExtendedPowellSingular => small::powell_singular(x, f),
            Function::Wood => small::wood(x, f),
            Function::KowalikOsborne => fits::kowalik_osborne(x, f),
            Function::BrownDennis => small::brown_dennis(x, f),
            Function::Osborne1 => fits::osborne_1(x, f),
            Function::BiggsExp6 => fits::biggs_exp6(x, f),
            Function::Osborne2 => fits::osborne_2(x, f),
            Function::Watson => scalable::watson(x, f),
            Function::Penalty1 => scalable::penalty_1(x, f),
            Function::Penalty2 => scalable::penalty_2(x, f),
            Function::VariablyDimensioned => scalable::variably_dimensioned(x, f),
            Function::Trigonometric => scalable::trigonometric(x, f),
            Function::BrownAlmostLinear => scalable::brown_almost_linear(x, f),
            Function::DiscreteBoundaryValue => scalable::discrete_boundary_value(x, f),
            Function::DiscreteIntegralEquation => scalable::discrete_integral_equation(x, f),
            Function::BroydenTridiagonal => scalable::broyden_tridiagonal(x, f),
            Function::BroydenBanded => scalable::broyden_banded(x, f),
            Function::LinearFullRank => scalable::linear_full_rank(x, f),
            Function::LinearRankOne => scalable::linear_rank_one(x, f),
            Function::LinearRankOneWithZeros => scalable::linear_rank_one_with_zeros(x, f),
            Function::Chebyquad => scalable::chebyquad(x, f),
        }
    }
}

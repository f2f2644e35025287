//! A formula as a tree: its value with any [`Number`], so that derivatives are exact, and what it reads.

use gravcal_estimation::Number;

use crate::sensors::{Moment, Need, Reads};

/// A formula.
#[derive(Clone, Debug, PartialEq)]
pub(super) enum Expression {
    Number(f64),
    Parameter(usize),
    /// Of a joint, or a further column.
    Variable(Variable, usize),
    Negative(Box<Expression>),
    Both(Operation, Box<[Expression; 2]>),
    /// Base and exponent.
    Power(Box<[Expression; 2]>),
    Function(Function, Box<Expression>),
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Operation {
    Sum,
    Difference,
    Product,
    Quotient,
}

/// What a pose says.
#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Variable {
    Torque,
    Coordinate,
    Position,
    Velocity,
    Direction,
    Temperature,
    Time,
    Further,
}

#[derive(Clone, Copy, Debug, PartialEq, Eq)]
pub(super) enum Function {
    Sin,
    Cos,
    Tan,
    Asin,
    Acos,
    Atan,
    Sinh,
    Cosh,
    Tanh,
    Exp,
    Ln,
    Sqrt,
    Abs,
    Sign,
}

impl Expression {
    /// Its value; that of a variable which a pose does not tell is not a number.
    pub fn value<N: Number>(&self, at: &Moment<'_, N>, x: &[N]) -> N {
        match self {
            Expression::Number(number) => N::from(*number),
            Expression::Parameter(place) => x[*place],
            Expression::Variable(variable, joint) => variable.of(at, *joint),
            Expression::Negative(inner) => -inner.value(at, x),
            Expression::Function(function, inner) => function.of(inner.value(at, x)),
            Expression::Power(both) => power(both, at, x),
            Expression::Both(operation, both) => {
                let [a, b] = [both[0].value(at, x), both[1].value(at, x)];
                match operation {
                    Operation::Sum => a + b,
                    Operation::Difference => a - b,
                    Operation::Product => a * b,
                    Operation::Quotient => a / b,
                }
            }
        }
    }

    /// What it depends on besides parameters.
    pub fn reads(&self) -> Reads {
        let mut reads = Reads::positions();
        self.visit(&mut |part| {
            let Expression::Variable(variable, joint) = part else { return };
            let known = std::mem::take(&mut reads);
            reads = match variable {
                Variable::Torque => known.torque(*joint),
                Variable::Coordinate => known.coordinate(*joint),
                Variable::Position | Variable::Further => known,
                Variable::Velocity => known.condition(Need::Velocity),
                Variable::Direction => known.condition(Need::Direction),
                Variable::Temperature => known.condition(Need::Temperature),
                Variable::Time => known.condition(Need::Time),
            };
        });
        reads
    }

    /// Whether it has this parameter.
    pub fn has_parameter(&self, place: usize) -> bool {
        let mut found = false;
        self.visit(&mut |part| found |= *part == Expression::Parameter(place));
        found
    }

    fn visit(&self, see: &mut dyn FnMut(&Expression)) {
        see(self);
        match self {
            Expression::Number(_) | Expression::Parameter(_) | Expression::Variable(..) => {}
            Expression::Negative(inner) | Expression::Function(_, inner) => inner.visit(see),
            Expression::Both(_, both) | Expression::Power(both) => both.iter().for_each(|inner| inner.visit(see)),
        }
    }
}

/// Powers by a constant are defined for bases below zero, too.
fn power<N: Number>([base, exponent]: &[Expression; 2], at: &Moment<'_, N>, x: &[N]) -> N {
    let base = base.value(at, x);
    let constant = match exponent {
        Expression::Number(constant) => Some(*constant),
        Expression::Negative(inner) => match **inner {
            Expression::Number(constant) => Some(-constant),
            _ => None,
        },
        _ => None,
    };
    match constant {
        Some(whole) if whole.fract() == 0.0 && whole.abs() <= 1e3 => base.powi(whole as i32),
        Some(constant) => base.powf(constant),
        None => base.powd(exponent.value(at, x)),
    }
}

impl Variable {
    fn of<N: Number>(self, at: &Moment<'_, N>, joint: usize) -> N {
        match self {
            Variable::Torque => at.torque(joint),
            Variable::Coordinate => at.coordinate(joint),
            Variable::Position => N::from(at.position(joint)),
            Variable::Velocity => N::from(at.velocity(joint)),
            Variable::Direction => N::from(at.direction(joint)),
            Variable::Temperature => N::from(at.temperature(joint).unwrap_or(f64::NAN)),
            Variable::Time => N::from(at.time()),
            Variable::Further => N::from(at.further(joint)),
        }
    }
}

/// From here on a hyperbolic tangent is ±1 to the last digit, and its slope below any.
const SATURATED: f64 = 40.0;

impl Function {
    fn of<N: Number>(self, x: N) -> N {
        match self {
            Function::Sin => x.sin(),
            Function::Cos => x.cos(),
            Function::Tan => x.tan(),
            Function::Asin => x.asin(),
            Function::Acos => x.acos(),
            Function::Atan => x.atan(),
            Function::Sinh => x.sinh(),
            Function::Cosh => x.cosh(),
            // As the ratio of two numbers that overflow it would have no slope.
            Function::Tanh if x.re().abs() > SATURATED => N::from(x.re().signum()),
            Function::Tanh => x.tanh(),
            Function::Exp => x.exp(),
            Function::Ln => x.ln(),
            Function::Sqrt => x.sqrt(),
            Function::Abs if x.re() < 0.0 => -x,
            Function::Abs => x,
            Function::Sign if x.re() == 0.0 => N::from(0.0),
            Function::Sign => N::from(x.re().signum()),
        }
    }
}

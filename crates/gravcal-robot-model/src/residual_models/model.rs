//! A model that sessions name: which residual it declares, with which parameters.

use std::fmt::Debug;
use std::sync::Arc;

use gravcal_dynamics::Chain;
use gravcal_recording::nearest_name;

use super::term::ResidualTerm;
use crate::sensors::{Options, ParameterSpec, RefusedOption};

/// A residual of one's own, by the name that sessions know it by.
///
/// [`Registry::with_residual_model`](crate::Registry::with_residual_model) makes it known to them.
pub trait ResidualModel: Debug + Send + Sync {
    /// Its name in files: `kind = "..."`.
    fn name(&self) -> &str;

    /// What was observed, in a line.
    fn help(&self) -> &str;

    /// Keys of the options that it takes.
    fn options(&self) -> &[&str] {
        &[]
    }

    /// What it calls the columns that it reads in the tables: keys of `columns` in files, all of them needed.
    fn columns(&self) -> Vec<&str> {
        Vec::new()
    }

    /// Its residual for one `[[residual]]` of a session.
    ///
    /// # Errors
    /// An option that it cannot do with, or a robot that it does not suit.
    fn declare(&self, setting: &Setting<'_>, options: &Options) -> Result<DeclaredResidual, RefusedOption>;
}

/// A residual with the parameters that it declares.
#[derive(Clone, Debug)]
pub struct DeclaredResidual {
    /// In the order in which the term takes them.
    pub parameters: Vec<ParameterSpec>,
    /// The function.
    pub term: Arc<dyn ResidualTerm>,
}

impl DeclaredResidual {
    /// A term with these parameters.
    pub fn new(parameters: impl Into<Vec<ParameterSpec>>, term: impl ResidualTerm + 'static) -> DeclaredResidual {
        DeclaredResidual { parameters: parameters.into(), term: Arc::new(term) }
    }
}

/// The robot, and the columns of a residual, for which a model is declared.
#[derive(Clone, Copy, Debug)]
pub struct Setting<'a> {
    chain: &'a Chain,
    /// What the model calls its columns.
    columns: &'a [&'a str],
    /// Place of the first of them among the further columns.
    first: usize,
}

impl<'a> Setting<'a> {
    /// A robot, and `columns` of a residual that stand behind each other from place `first` among the further columns.
    pub fn new(chain: &'a Chain, columns: &'a [&'a str], first: usize) -> Setting<'a> {
        Setting { chain, columns, first }
    }

    /// The robot.
    pub fn chain(&self) -> &'a Chain {
        self.chain
    }

    /// The place of one of the model's own [columns](ResidualModel::columns), for [`Scene::column`](super::Scene::column); beyond all
    /// places for a name that is none of them, where no number stands.
    pub fn column(&self, name: &str) -> usize {
        let own = self.columns.iter().position(|known| *known == name);
        own.map_or(usize::MAX, |own| self.first + own)
    }

    /// Joints that move a link.
    pub fn joints_moving(&self, link: usize) -> Vec<usize> {
        (0..self.chain.joint_count()).filter(|joint| self.chain.moves(*joint, link)).collect()
    }

    /// The link that an option names, by its index; the only one need not be named.
    ///
    /// # Errors
    /// There is none of this name, or none is named where there are several.
    pub fn link(&self, options: &Options, key: &str) -> Result<usize, RefusedOption> {
        let names: Vec<&str> = self.chain.links().iter().map(|link| link.name.as_str()).collect();
        named("link", &names, options, key)
    }

    /// The joint that an option names, by its index; the only one need not be named.
    ///
    /// # Errors
    /// There is none of this name, or none is named where there are several.
    pub fn joint(&self, options: &Options, key: &str) -> Result<usize, RefusedOption> {
        let names: Vec<&str> = self.chain.joints().iter().map(|joint| joint.name.as_str()).collect();
        named("joint", &names, options, key)
    }

    /// Three numbers that an option lists, where it is given.
    ///
    /// # Errors
    /// It lists something else.
    pub fn vector(&self, options: &Options, key: &str) -> Result<Option<[f64; 3]>, RefusedOption> {
        let Some(numbers) = options.numbers(key)? else { return Ok(None) };
        let found = numbers.len();
        let three = numbers.try_into();
        three
            .map(Some)
            .map_err(|_| RefusedOption::new(key, format!("expected three numbers, x, y and z, found {found}")))
    }

    /// A number above zero, which there must be.
    ///
    /// # Errors
    /// There is none, or something else.
    pub fn positive(&self, options: &Options, key: &str, what: &str) -> Result<f64, RefusedOption> {
        let number = options.number(key)?.filter(|number| *number > 0.0);
        number.ok_or_else(|| RefusedOption::new(key, format!("{what}: add {key}, a number above zero")))
    }
}

fn named(what: &str, names: &[&str], options: &Options, key: &str) -> Result<usize, RefusedOption> {
    let known = || names.join(", ");
    match (options.text(key)?, names) {
        (None, [_]) => Ok(0),
        (None, _) => Err(RefusedOption::new(key, format!("which {what} is it? add {key} = \"…\", one of {}", known()))),
        (Some(name), _) => names.iter().position(|known| *known == name).ok_or_else(|| {
            let near = nearest_name(name, names).map_or_else(String::new, |near| format!(" (did you mean `{near}`?)"));
            RefusedOption::new(key, format!("there is no {what} `{name}`{near}; known: {}", known()))
        }),
    }
}

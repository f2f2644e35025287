//! A LaTeX table for papers (with `booktabs`): each value rounded to the second digit of its standard deviation, offsets of angles in
//! degrees.

use super::markdown::{CONVENTION, cells};
use super::rows::{Row, rows};
use super::{Export, Exported, head};

pub(super) fn export(export: &Export<'_>) -> Exported {
    let head: String = head(export, &CONVENTION, &[]).iter().map(|line| format!("% {line}\n")).collect();
    let rows: String = rows(export.estimate).iter().map(line).collect();
    let text = format!(
        "{head}% Needs \\usepackage{{booktabs}}.\n\\begin{{tabular}}{{llrrr}}\n  \\toprule\n  parameter & unit & value & $\\pm$ & nominal \
         \\\\\n  \\midrule\n{rows}  \\bottomrule\n\\end{{tabular}}\n"
    );
    Exported { text, remarks: Vec::new() }
}

fn line(row: &Row<'_>) -> String {
    let [unit, value, std, nominal] = cells(row);
    let [value, std, nominal] = [value, std, nominal].map(|text| number(&text));
    format!("  {} & {} & {value} & {std} & {nominal} \\\\\n", escaped(&row.name), escaped(&unit))
}

/// A number in mathematical mode, which has a proper minus, with powers of ten written out; words as they are.
fn number(text: &str) -> String {
    match (text.parse::<f64>(), text.split_once('e')) {
        (Ok(_), Some((mantissa, exponent))) => format!("${mantissa} \\times 10^{{{exponent}}}$"),
        (Ok(_), None) => format!("${text}$"),
        (Err(_), _) => text.to_owned(),
    }
}

fn escaped(text: &str) -> String {
    let of = |c: char| match c {
        '\\' => "\\textbackslash{}".to_owned(),
        '_' | '&' | '%' | '$' | '#' | '{' | '}' => format!("\\{c}"),
        '~' | '^' => format!("\\{c}{{}}"),
        '·' => "$\\cdot$".to_owned(),
        '²' => "$^2$".to_owned(),
        other => other.to_string(),
    };
    text.chars().map(of).collect()
}

//! Where it comes from.

use maud::{Markup, html};

use crate::provenance::Provenance;

pub(super) fn section(provenance: &Provenance) -> Markup {
    let (program, inputs, options) = provenance.reported();
    html! {
        section {
            h2 { "Where it comes from" }
            p { (program) "; estimators " (options.estimators.join(", ")) "; solver " (options.solver) "." }
            div.wide { table {
                thead { tr { th { "file" } th.number { "bytes" } th { "SHA-256" } } }
                tbody { @for input in inputs {
                    tr { td { (input.path) } td.number { (input.bytes) } td.hash { (input.sha256) } }
                } }
            } }
        }
    }
}

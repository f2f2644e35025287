//! The frame of a page: head, style, data, script.

use maud::{DOCTYPE, Markup, PreEscaped, html};

const STYLE: &str = include_str!("page.css");
/// Whatever the page holds, it asks nobody for anything.
const POLICY: &str = "default-src 'none'; style-src 'unsafe-inline'; script-src 'unsafe-inline'; img-src data:";

/// A page with this title and body; `figures`: the data of its canvases as JSON, and the script that draws them.
pub(crate) fn document(title: &str, body: &Markup, figures: Option<(&str, &str)>) -> String {
    let page = html! {
        (DOCTYPE)
        html lang="en" {
            head {
                meta charset="utf-8";
                meta name="viewport" content="width=device-width, initial-scale=1";
                meta name="color-scheme" content="light dark";
                meta http-equiv="Content-Security-Policy" content=(POLICY);
                link rel="icon" href="data:,";
                title { (title) }
                style { (PreEscaped(STYLE)) }
            }
            body {
                main { (body) }
                @if let Some((data, script)) = figures {
                    // A name with `</script>` in it must not end the data.
                    script type="application/json" id="data" { (PreEscaped(data.replace('<', "\\u003c"))) }
                    script { (PreEscaped(script)) }
                }
            }
        }
    };
    page.into_string()
}

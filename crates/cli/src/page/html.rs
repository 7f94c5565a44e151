//! One file that holds everything: style, script, data and pictures.

use base64::Engine;
use base64::engine::general_purpose::STANDARD;
use serde_json::Value;

use crate::error::CliError;

const PAGE: &str = include_str!("page.html");
const STYLE: &str = include_str!("page.css");
/// One script in parts, in the order in which they need each other.
const SCRIPT: [&str; 6] = [
    include_str!("js/basics.js"),
    include_str!("js/pictures.js"),
    include_str!("js/viewer.js"),
    include_str!("js/plots.js"),
    include_str!("js/sections.js"),
    include_str!("js/start.js"),
];

/// Bytes that the script finds under a name.
pub struct Blob {
    pub id: String,
    pub bytes: Vec<u8>,
}

/// Text between tags.
fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// JSON inside a script element, which ends at `</` and misreads `<!--`, whatever is around them.
fn embedded(data: &Value) -> Result<String, serde_json::Error> {
    Ok(serde_json::to_string(data)?.replace('<', "\\u003c"))
}

/// The page.
pub fn assemble(title: &str, data: &Value, blobs: &[Blob]) -> Result<String, CliError> {
    let json = embedded(data).map_err(|e| CliError::Said(format!("the page cannot be encoded: {e}")))?;
    let mut elements = format!("<script type=\"application/json\" id=\"data\">{json}</script>\n");
    for Blob { id, bytes } in blobs {
        elements.push_str(&format!("<script type=\"application/octet-stream\" id=\"{id}\">"));
        STANDARD.encode_string(bytes, &mut elements);
        elements.push_str("</script>\n");
    }
    // What is filled in may hold the marks of other places, so the template is cut before anything is filled in.
    let parts = [("{{title}}", escaped(title)), ("{{style}}", STYLE.into()), ("{{data}}", elements)];
    let (mut page, mut rest) = (String::new(), PAGE);
    for (mark, value) in parts.into_iter().chain([("{{script}}", SCRIPT.concat())]) {
        let (before, after) = rest.split_once(mark).unwrap_or((rest, ""));
        page.push_str(before);
        page.push_str(&value);
        rest = after;
    }
    page.push_str(rest);
    Ok(page)
}

#[cfg(test)]
mod tests {
    use serde_json::json;

    use super::*;

    #[test]
    fn nothing_in_a_name_becomes_markup() {
        let name = "</script><img src=x onerror=alert(1)><!--<script>&\"{{script}}";
        let blob = Blob { id: "picture-0".into(), bytes: vec![1, 2, 3] };
        let page = assemble(name, &json!({ "title": name }), &[blob]).unwrap();
        assert!(!page.contains("<img src=x") && !page.contains("<!--<script"));
        assert!(page.contains("&lt;/script&gt;&lt;img src=x"));
        // Three of the page's own: data, a picture and the script, each closed once.
        assert_eq!(page.matches("</script>").count(), 3);
        assert!(page.contains(">AQID</script>"));
        let data = page.split("id=\"data\">").nth(1).unwrap().split("</script>").next().unwrap();
        assert_eq!(serde_json::from_str::<Value>(data).unwrap()["title"], name, "the data is unchanged");
        assert!(page.ends_with("</html>\n") && !page.contains("{{title}}") && !page.contains("{{style}}"));
    }

    #[test]
    fn the_page_asks_nothing_of_a_network() {
        let page = assemble("any", &json!({}), &[]).unwrap();
        assert!(page.contains("default-src 'none'"));
        // Names of languages of markup are the only addresses.
        for (at, _) in page.match_indices("://") {
            let scheme = page[..at].rfind(|c: char| !c.is_ascii_alphabetic()).map_or(0, |i| i + 1);
            assert!(page[scheme..].starts_with("http://www.w3.org/2000/svg"), "{:?}", page[scheme..].lines().next());
        }
        for word in ["fetch(", "XMLHttpRequest", "import(", "innerHTML", "eval("] {
            assert!(!page.contains(word), "{word}");
        }
    }
}

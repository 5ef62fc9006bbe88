//! Text that becomes part of a page.

/// `text` where HTML expects text or a quoted attribute.
pub(super) fn escape(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// JSON where HTML expects a script: no string in it can end the script or begin a comment.
pub(super) fn script(json: &str) -> String {
    json.replace('<', "\\u003c")
}

/// `template` with each `{{name}}` replaced. What is put in is not looked at again, so it may hold braces itself.
pub(super) fn fill(template: &str, values: &[(&str, &str)]) -> String {
    let mut parts = template.split("{{");
    let mut page = parts.next().unwrap_or_default().to_string();
    for part in parts {
        let (name, rest) = part.split_once("}}").unwrap_or((part, ""));
        page.extend(values.iter().filter(|(key, _)| *key == name).map(|(_, value)| *value));
        page.push_str(rest);
    }
    page
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_filled_in_is_not_filled_again() {
        let page = fill("<{{a}}|{{b}}|{{a}}>", &[("a", "{{b}}"), ("b", "2")]);
        assert_eq!(page, "<{{b}}|2|{{b}}>");
    }

    #[test]
    fn a_script_keeps_its_strings_and_ends_where_it_should() {
        let hostile = "</script><!-- \u{2028} & \"";
        let json = script(&serde_json::to_string(hostile).unwrap());
        assert!(!json.contains('<'));
        assert_eq!(serde_json::from_str::<String>(&json).unwrap(), hostile);
    }
}

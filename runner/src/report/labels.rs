//! Tables for narrow screens: each cell carries the heading of its column, so that a style can set rows below each other.

/// The page with `data-label` on each cell of a table that has a head.
pub fn labelled(page: &str) -> String {
    let mut out = String::with_capacity(page.len() + page.len() / 8);
    let mut rest = page;
    while let Some(start) = rest.find("<table") {
        let end = rest[start..].find("</table>").map_or(rest.len(), |e| start + e);
        out.push_str(&rest[..start]);
        table(&rest[start..end], &mut out);
        rest = &rest[end..];
    }
    out.push_str(rest);
    out
}

fn table(text: &str, out: &mut String) {
    let Some((head, body)) = text.split_once("</thead>") else { return out.push_str(text) };
    let heads: Vec<String> = head.split("<th").skip(1).filter(|h| !h.starts_with("ead")).map(plain).collect();
    out.push_str(head);
    out.push_str("</thead>");
    let mut column = 0;
    for (k, part) in body.split("<td").enumerate() {
        if k == 0 {
            out.push_str(part);
            continue;
        }
        let label = heads.get(column).map_or("", String::as_str);
        out.push_str(&format!("<td data-label=\"{label}\"{part}"));
        column += span(part);
        if part.contains("</tr>") {
            column = 0;
        }
    }
}

/// Text of a heading, without tags.
fn plain(cell: &str) -> String {
    let inner = cell.split_once('>').map_or("", |(_, inner)| inner);
    let inner = inner.split("</th>").next().unwrap_or("");
    let mut text = String::new();
    let mut is_tag = false;
    for c in inner.chars() {
        match c {
            '<' => is_tag = true,
            '>' => is_tag = false,
            _ if !is_tag => text.push(c),
            _ => {}
        }
    }
    text.replace('"', "&quot;")
}

fn span(cell: &str) -> usize {
    let opening = cell.split('>').next().unwrap_or("");
    let told = opening.split_once("colspan=\"").and_then(|(_, n)| n.split('"').next()?.parse().ok());
    told.unwrap_or(1)
}

#[cfg(test)]
mod tests {
    use super::labelled;

    #[test]
    fn cells_carry_the_heading_of_their_column() {
        let page = "<p>a</p><table><thead><tr><th></th><th class=\"n\">value <b>x</b></th><th>unit</th><th>name</th></tr></thead>\
                    <tbody><tr><td>G</td><td class=\"n\">1</td><td colspan=\"2\">Pa</td></tr><tr><td>H</td><td>2</td></tr></tbody></table>\
                    <table><tr><td>no head</td></tr></table>";
        let found = labelled(page);
        assert!(
            found.contains("<td data-label=\"\">G</td><td data-label=\"value x\" class=\"n\">1</td>"),
            "{found}"
        );
        assert!(found.contains("<td data-label=\"unit\" colspan=\"2\">Pa</td>"), "{found}");
        assert!(found.contains("<td data-label=\"value x\">2</td>"), "{found}");
        assert!(
            found.contains("<td>no head</td>")
                && found.starts_with("<p>a</p>")
                && found.ends_with("</table>")
        );
    }
}

//! Tables as comma-separated values (RFC 4180): fields with commas, quotes or line breaks stand in quotes.

use std::collections::BTreeMap;

/// A row by its columns' names.
pub type Row = BTreeMap<String, String>;

/// A file's text of `rows`: the columns in this order, empty where a row has none of that name.
pub fn write(columns: &[&str], rows: &[Row]) -> String {
    let line = |fields: Vec<String>| fields.join(",") + "\n";
    let head = line(columns.iter().map(|name| quoted(name)).collect());
    let field = |row: &Row, name: &str| row.get(name).map_or_else(String::new, |value| quoted(value));
    let body = rows.iter().map(|row| line(columns.iter().map(|name| field(row, name)).collect()));
    head + &body.collect::<String>()
}

/// The rows of a file's text, whose first line names the columns; says what is wrong with text that is no table.
pub fn read(text: &str) -> Result<Vec<Row>, String> {
    let mut lines = fields(text)?.into_iter();
    let Some(columns) = lines.next() else { return Ok(Vec::new()) };
    let row = |(index, fields): (usize, Vec<String>)| {
        if fields.len() == columns.len() {
            Ok(columns.iter().cloned().zip(fields).collect())
        } else {
            Err(format!("row {} has {} fields, the head {}", index + 2, fields.len(), columns.len()))
        }
    };
    lines.enumerate().map(row).collect()
}

fn quoted(field: &str) -> String {
    if field.contains([',', '"', '\n', '\r']) { format!("\"{}\"", field.replace('"', "\"\"")) } else { field.into() }
}

fn fields(text: &str) -> Result<Vec<Vec<String>>, String> {
    let (mut rows, mut row, mut field, mut open) = (Vec::new(), Vec::new(), String::new(), false);
    let mut letters = text.trim_start_matches('\u{feff}').chars().peekable();
    while let Some(letter) = letters.next() {
        match letter {
            '"' if open && letters.peek() == Some(&'"') => {
                letters.next();
                field.push('"');
            }
            '"' => open = !open,
            ',' if !open => row.push(std::mem::take(&mut field)),
            '\r' if !open => (),
            '\n' if !open => {
                row.push(std::mem::take(&mut field));
                rows.push(std::mem::take(&mut row));
            }
            other => field.push(other),
        }
    }
    if open {
        return Err("a quote is not closed".into());
    }
    if !field.is_empty() || !row.is_empty() {
        row.push(field);
        rows.push(row);
    }
    rows.retain(|row| row.len() > 1 || row.iter().any(|field| !field.is_empty()));
    Ok(rows)
}

#[cfg(test)]
mod tests {
    use super::*;

    #[test]
    fn what_is_written_is_read_again() {
        let odd = r#"{"accuracy": 0.3, "capture": "compute"}"#;
        let row: Row =
            [("a", odd), ("b", "two\nlines, \"quoted\""), ("c", "")].map(|(k, v)| (k.into(), v.into())).into();
        let text = write(&["a", "b", "c"], &[row.clone(), row.clone()]);
        assert_eq!(read(&text), Ok(vec![row.clone(), row]));
    }

    #[test]
    fn other_programs_line_ends_are_read() {
        let rows = read("\u{feff}a,b\r\n1,\"x\"\r\n").unwrap();
        assert_eq!((rows.len(), rows[0]["a"].as_str(), rows[0]["b"].as_str()), (1, "1", "x"));
        assert!(read("").unwrap().is_empty());
    }

    #[test]
    fn broken_text_is_refused() {
        assert!(read("a,b\n1\n").unwrap_err().contains("row 2"));
        assert!(read("a\n\"1\n").unwrap_err().contains("quote"));
    }
}

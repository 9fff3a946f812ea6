//! The gallery as one HTML page beside its pictures.

use super::{Block, Check, Page, Summary, Table, Verdict};
use std::fmt::Write;
use supple::Result;
use supple_pictures::{Image, number};

const STYLE: &str = include_str!("gallery.css");

/// `index.html` of the figures in `summary`, whose pages are `pages`.
pub(super) fn index(summary: &Summary, pages: &[Page]) -> Result<String> {
    let (held, all) = summary.checks();
    let seconds: f64 = summary.figures.iter().map(|f| f.seconds).sum();
    let mut out = format!(
        "<!doctype html>\n<html lang=\"en\">\n<head>\n<meta charset=\"utf-8\">\n\
         <meta name=\"viewport\" content=\"width=device-width, initial-scale=1\">\n\
         <title>supple: the figures</title>\n<style>\n{STYLE}</style>\n</head>\n<body>\n<header>\n\
         <h1>supple: the figures</h1>\n\
         <p>Every figure of <cite>Parametric Skeletons with Reduced Soft-Tissue Deformations</cite> (Tapia, Romero, \
         Pérez, Otaduy 2021) as a scene that was run, drawn and measured by <code>supple figures</code>.</p>\n\
         <p class=\"{}\">{held} of {all} checks hold.</p>\n\
         <p class=\"aside\">{} · {} size · {:.0} s</p>\n</header>\n",
        if held == all { "pass" } else { "fail" },
        escaped(&summary.machine),
        summary.size,
        seconds,
    );
    out += "<nav aria-label=\"Figures\">\n<table>\n<thead><tr><th>figure</th><th>paper</th><th>checks</th>\
            <th>s</th></tr></thead>\n<tbody>\n";
    for verdict in &summary.figures {
        out += &contents_row(verdict);
    }
    out += "</tbody>\n</table>\n</nav>\n<main>\n";
    for (verdict, page) in summary.figures.iter().zip(pages) {
        out += &section(verdict, page)?;
    }
    out += "</main>\n</body>\n</html>\n";
    Ok(out)
}

fn contents_row(verdict: &Verdict) -> String {
    let held = verdict.checks.iter().filter(|c| c.holds()).count();
    let (class, told) = match &verdict.error {
        Some(_) => ("fail", "not drawn".to_string()),
        None if verdict.holds() => ("pass", format!("{held} of {}", verdict.checks.len())),
        None => ("fail", format!("{held} of {}", verdict.checks.len())),
    };
    format!(
        "<tr><td><a href=\"#{}\">{}</a></td><td>{}</td><td class=\"{class}\">{told}</td><td>{:.1}</td></tr>\n",
        verdict.name,
        escaped(verdict.title),
        escaped(verdict.paper),
        verdict.seconds
    )
}

fn section(verdict: &Verdict, page: &Page) -> Result<String> {
    let mut out = format!(
        "<section id=\"{}\">\n<h2>{}</h2>\n<p class=\"aside\">",
        verdict.name,
        escaped(verdict.title)
    );
    if !verdict.paper.is_empty() {
        let _ = write!(out, "Paper: {} · ", escaped(verdict.paper));
    }
    let _ = writeln!(
        out,
        "<code>supple figures --only {}</code> · {:.1} s</p>",
        verdict.name, verdict.seconds
    );
    if let Some(error) = &verdict.error {
        let _ = writeln!(out, "<p class=\"fail\">Not drawn: {}</p>", escaped(error));
    }
    for block in &page.blocks {
        match block {
            Block::Text(text) => {
                let _ = writeln!(out, "<p>{}</p>", escaped(text));
            }
            Block::Picture {
                name,
                caption,
                image,
            } => out += &picture(verdict.name, name, caption, image),
            // Its file plays where a still one is shown.
            Block::Animation {
                name,
                caption,
                animation,
            } => {
                let first = animation.frames.first();
                out += &first.map_or(String::new(), |i| picture(verdict.name, name, caption, i));
            }
            Block::Data { name, .. } => {
                let _ = writeln!(
                    out,
                    "<p><a href=\"{}/{name}.json\">{name}.json</a></p>",
                    verdict.name
                );
            }
            Block::Table(table) => out += &html_table(table),
            Block::Curves(curves) => {
                let told = format!("{}: {} over {}", curves.title, curves.y, curves.x);
                let _ = writeln!(
                    out,
                    "<figure class=\"curves\" style=\"max-width: {}px\" role=\"img\" aria-label=\"{}\">{}</figure>",
                    curves.width(),
                    escaped(&told),
                    curves.svg()?
                );
            }
        }
    }
    if !page.checks.is_empty() {
        out += &check_table(&page.checks);
    }
    out += "</section>\n";
    Ok(out)
}

/// A picture of the size of `image` in the figure's folder.
fn picture(figure: &str, name: &str, caption: &str, image: &Image) -> String {
    let caption = escaped(caption);
    format!(
        "<figure><a href=\"{figure}/{name}.png\"><img src=\"{figure}/{name}.png\" alt=\"{caption}\" width=\"{}\" \
         height=\"{}\" loading=\"lazy\"></a><figcaption>{caption}</figcaption></figure>\n",
        image.width, image.height
    )
}

fn html_table(table: &Table) -> String {
    let mut out = format!(
        "<table>\n<caption>{}</caption>\n<thead><tr>",
        escaped(&table.caption)
    );
    for column in &table.columns {
        let _ = write!(out, "<th>{}</th>", escaped(column));
    }
    out += "</tr></thead>\n<tbody>\n";
    for row in &table.rows {
        out += "<tr>";
        for cell in row {
            let _ = write!(out, "<td>{}</td>", escaped(cell));
        }
        out += "</tr>\n";
    }
    out + "</tbody>\n</table>\n"
}

fn check_table(checks: &[Check]) -> String {
    let mut out = String::from(
        "<table class=\"checks\">\n<caption>Checks</caption>\n<thead><tr><th>what</th><th>measured</th>\
         <th>must be</th><th></th></tr></thead>\n<tbody>\n",
    );
    for check in checks {
        let (class, mark) = match check.holds() {
            true => ("pass", "holds"),
            false => ("fail", "fails"),
        };
        let unit = match check.unit {
            "" => String::new(),
            unit => format!(" {}", escaped(unit)),
        };
        let _ = writeln!(
            out,
            "<tr><td>{}</td><td>{}{unit}</td><td>{}{unit}</td><td class=\"{class}\">{mark}</td></tr>",
            escaped(&check.what),
            number(check.value),
            check.bound
        );
    }
    out + "</tbody>\n</table>\n"
}

/// `text` as the text of an element or a quoted attribute.
fn escaped(text: &str) -> String {
    let mut out = String::with_capacity(text.len());
    for c in text.chars() {
        match c {
            '&' => out += "&amp;",
            '<' => out += "&lt;",
            '>' => out += "&gt;",
            '"' => out += "&quot;",
            _ => out.push(c),
        }
    }
    out
}

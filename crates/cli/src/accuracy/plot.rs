//! Plots on logarithmic axes, as SVG that looks right on light and dark ground.

use std::fmt::Write;

use ergodic_assess::accuracy::Interval;

/// A curve with its band: (x, y with interval).
pub struct Band {
    pub name: String,
    pub points: Vec<(f64, Interval)>,
}

const WIDTH: f64 = 760.0;
const HEIGHT: f64 = 480.0;
/// Left, top, right, bottom.
const MARGIN: [f64; 4] = [78.0, 44.0, 150.0, 56.0];

/// Colours that people who see few colours can tell apart (Okabe and Ito 2008), and marks for everybody.
const COLORS: [&str; 8] = ["#0072b2", "#d55e00", "#009e73", "#cc79a7", "#e69f00", "#56b4e9", "#8c6d31", "#777777"];

/// A logarithmic axis.
struct Axis {
    low: f64,
    high: f64,
    from: f64,
    to: f64,
}

impl Axis {
    /// Over all values, widened a little; the values are positive.
    fn new(values: impl Iterator<Item = f64>, from: f64, to: f64) -> Self {
        let (low, high) = values.fold((f64::INFINITY, 0f64), |(low, high), v| (low.min(v), high.max(v)));
        let (low, high) = if low < high { (low.log10(), high.log10()) } else { (low.log10() - 0.5, low.log10() + 0.5) };
        let room = 0.04 * (high - low);
        Self { low: low - room, high: high + room, from, to }
    }

    fn at(&self, value: f64) -> f64 {
        self.from + (value.log10() - self.low) / (self.high - self.low) * (self.to - self.from)
    }

    /// Values with a line, and whether it has a number: powers of ten, and 2 and 5 times these where there is room.
    fn ticks(&self) -> Vec<(f64, bool)> {
        let wide = self.high - self.low > 3.0;
        let decades = self.low.floor() as i32..=self.high.ceil() as i32;
        let ticks = decades.flat_map(|d| (1..10).map(move |m| (f64::from(m) * 10f64.powi(d), m)));
        let inside = ticks.filter(|(v, _)| (self.low..=self.high).contains(&v.log10()));
        inside.map(|(v, m)| (v, m == 1 || (!wide && (m == 2 || m == 5)))).collect()
    }
}

/// A number as an axis shows it.
fn number(value: f64) -> String {
    if (1e-3..1e5).contains(&value) {
        let text = format!("{value:.4}");
        text.trim_end_matches('0').trim_end_matches('.').into()
    } else {
        format!("{value:.0e}")
    }
}

fn escaped(text: &str) -> String {
    text.replace('&', "&amp;").replace('<', "&lt;").replace('>', "&gt;").replace('"', "&quot;")
}

/// The plot. Points that are not positive are left out: a logarithm has no place for them.
pub fn log_log(title: &str, x_name: &str, y_name: &str, bands: &[Band]) -> String {
    let [left, top, right, bottom] = MARGIN;
    let shown: Vec<(&str, Vec<&(f64, Interval)>)> = bands
        .iter()
        .map(|band| (&band.name[..], band.points.iter().filter(|(x, y)| *x > 0.0 && y.value > 0.0).collect()))
        .collect();
    let all = || shown.iter().flat_map(|(_, points)| points.iter());
    let mut svg = format!(
        "<svg xmlns=\"http://www.w3.org/2000/svg\" viewBox=\"0 0 {WIDTH} {HEIGHT}\" role=\"img\" font-family=\"sans-serif\" \
         font-size=\"13\">\n<title>{}</title>\n<style>.ink{{fill:#222}}.grid{{stroke:#888;stroke-opacity:.3}}.frame{{stroke:#888;fill:none}}\
         @media(prefers-color-scheme:dark){{.ink{{fill:#ddd}}}}</style>\n<text class=\"ink\" x=\"{left}\" y=\"24\" \
         font-size=\"16\">{}</text>\n",
        escaped(title),
        escaped(title)
    );
    if all().next().is_none() {
        let _ = writeln!(
            svg,
            "<text class=\"ink\" x=\"{left}\" y=\"80\">nothing that a logarithm could show</text>\n</svg>"
        );
        return svg;
    }
    let low_of = |y: &Interval| if y.low > 0.0 { y.low } else { y.value * 0.5 };
    let x = Axis::new(all().map(|(x, _)| *x), left, WIDTH - right);
    let y = Axis::new(all().flat_map(|(_, y)| [low_of(y), y.high]), HEIGHT - bottom, top);
    for (value, named) in x.ticks() {
        let at = x.at(value);
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{at:.1}\" x2=\"{at:.1}\" y1=\"{top}\" y2=\"{}\"/>",
            HEIGHT - bottom
        );
        if named {
            let (y, text) = (HEIGHT - bottom + 18.0, number(value));
            let _ = writeln!(svg, "<text class=\"ink\" x=\"{at:.1}\" y=\"{y}\" text-anchor=\"middle\">{text}</text>");
        }
    }
    for (value, named) in y.ticks() {
        let at = y.at(value);
        let _ = writeln!(
            svg,
            "<line class=\"grid\" x1=\"{left}\" x2=\"{}\" y1=\"{at:.1}\" y2=\"{at:.1}\"/>",
            WIDTH - right
        );
        if named {
            let (x, y, text) = (left - 8.0, at + 4.0, number(value));
            let _ = writeln!(svg, "<text class=\"ink\" x=\"{x}\" y=\"{y:.1}\" text-anchor=\"end\">{text}</text>");
        }
    }
    let _ = writeln!(
        svg,
        "<rect class=\"frame\" x=\"{left}\" y=\"{top}\" width=\"{}\" height=\"{}\"/>\n<text class=\"ink\" x=\"{}\" y=\"{}\" \
         text-anchor=\"middle\">{}</text>\n<text class=\"ink\" transform=\"translate(20 {}) rotate(-90)\" \
         text-anchor=\"middle\">{}</text>",
        WIDTH - left - right,
        HEIGHT - top - bottom,
        0.5 * (left + WIDTH - right),
        HEIGHT - 14.0,
        escaped(x_name),
        0.5 * (top + HEIGHT - bottom),
        escaped(y_name),
    );
    // Names stand at the right, near the ends of their curves but clear of each other.
    let mut labels: Vec<(f64, usize)> = Vec::new();
    for (i, (_, points)) in shown.iter().enumerate() {
        let color = COLORS[i % COLORS.len()];
        let upper = points.iter().map(|(t, e)| format!("{:.1},{:.1}", x.at(*t), y.at(e.high)));
        let lower = points.iter().rev().map(|(t, e)| format!("{:.1},{:.1}", x.at(*t), y.at(low_of(e))));
        let outline = upper.chain(lower).collect::<Vec<_>>().join(" ");
        let _ = writeln!(svg, "<polygon points=\"{outline}\" fill=\"{color}\" fill-opacity=\"0.18\"/>");
        let line: Vec<String> = points.iter().map(|(t, e)| format!("{:.1},{:.1}", x.at(*t), y.at(e.value))).collect();
        let line_text = line.join(" ");
        let _ = writeln!(svg, "<polyline points=\"{line_text}\" fill=\"none\" stroke=\"{color}\" stroke-width=\"2\"/>");
        for (t, e) in points {
            let (cx, cy) = (x.at(*t), y.at(e.value));
            let _ = writeln!(svg, "<circle cx=\"{cx:.1}\" cy=\"{cy:.1}\" r=\"3\" fill=\"{color}\"/>");
        }
        if let Some((_, e)) = points.last() {
            labels.push((y.at(e.value), i));
        }
    }
    labels.sort_unstable_by(|a, b| a.0.total_cmp(&b.0));
    let mut free = top;
    for (at, i) in labels {
        let at = at.max(free);
        free = at + 17.0;
        let (name, color) = (escaped(shown[i].0), COLORS[i % COLORS.len()]);
        let x = WIDTH - right + 10.0;
        let _ = writeln!(
            svg,
            "<circle cx=\"{}\" cy=\"{at:.1}\" r=\"4\" fill=\"{color}\"/><text class=\"ink\" x=\"{}\" y=\"{:.1}\">{name}</text>",
            x + 4.0,
            x + 14.0,
            at + 4.0
        );
    }
    svg.push_str("</svg>\n");
    svg
}

#[cfg(test)]
mod tests {
    use super::*;

    fn point(x: f64, y: f64) -> (f64, Interval) {
        (x, Interval { value: y, low: 0.8 * y, high: 1.3 * y, error: 0.1 * y })
    }

    #[test]
    fn points_lie_where_their_logarithms_are() {
        let axis = Axis::new([1.0, 100.0].into_iter(), 0.0, 100.0);
        assert!((axis.at(10.0) - 50.0).abs() < 1e-9);
        assert!(axis.at(1.0) > 0.0 && axis.at(100.0) < 100.0);
        assert!(axis.ticks().iter().any(|(v, named)| *v == 10.0 && *named));
    }

    #[test]
    fn every_method_has_a_name_and_as_many_marks_as_points() {
        let bands = [
            Band { name: "a<b".into(), points: vec![point(0.25, 0.1), point(0.5, 0.05), point(1.0, -0.01)] },
            Band { name: "c".into(), points: vec![point(0.25, 0.2), point(0.5, 0.05)] },
        ];
        let svg = log_log("errors", "s", "relMSE", &bands);
        assert!(svg.contains("a&lt;b") && !svg.contains("NaN") && !svg.contains("inf"));
        // Two points of each, and two in the legend.
        assert_eq!(svg.matches("<circle").count(), 6);
        assert!(log_log("none", "s", "e", &[]).contains("nothing"));
    }
}

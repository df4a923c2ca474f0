//! PDF output of a drawing: one page of its size, with embedded subsets of the fonts.

use std::collections::BTreeMap;
use std::io::Write as _;

use flate2::Compression;
use flate2::write::ZlibEncoder;
use pdf_writer::types::{CidFontType, FontFlags, SystemInfo, UnicodeCmap};
use pdf_writer::{Content, Filter, Finish as _, Name, Pdf, Rect, Ref, Str, TextStr};
use subsetter::{GlyphRemapper, subset};

use super::canvas::{BLACK, Canvas, Colour, Item, Pen, Segment, Text};
use super::font::{FILES, Fonts, NAMES};

/// Names of the fonts in the resources of the page.
const RESOURCES: [Name<'static>; 2] = [Name(b"F0"), Name(b"F1")];

/// Glyphs of one font that a document uses: their indices in the font, and in the embedded subset.
#[derive(Default)]
struct UsedGlyphs {
    numbers: GlyphRemapper,
    letters: BTreeMap<u16, char>,
}

/// Writes a drawing as a PDF document with a title; equal drawings give equal bytes.
pub(crate) fn write(canvas: &Canvas, fonts: &Fonts, title: &str) -> Vec<u8> {
    let mut used = [UsedGlyphs::default(), UsedGlyphs::default()];
    let page_content = content_stream(canvas, &mut used);
    let mut pdf = Pdf::new();
    let mut next = Ref::new(1);
    let [catalog, pages, page, drawing, info] = [(); 5].map(|()| next.bump());
    let embedded: Vec<(usize, [Ref; 5])> = (0..FILES.len())
        .filter(|font| !used[*font].letters.is_empty())
        .map(|font| (font, [(); 5].map(|()| next.bump())))
        .collect();
    pdf.catalog(catalog).pages(pages);
    pdf.document_info(info)
        .title(TextStr(title))
        .producer(TextStr("stosszahl"));
    pdf.pages(pages).kids([page]).count(1);
    let mut sheet = pdf.page(page);
    sheet.parent(pages).contents(drawing).media_box(Rect::new(
        0.0,
        0.0,
        canvas.size[0] as f32,
        canvas.size[1] as f32,
    ));
    let mut resources = sheet.resources();
    let mut names = resources.fonts();
    for (font, places) in &embedded {
        names.pair(RESOURCES[*font], places[0]);
    }
    names.finish();
    resources.finish();
    sheet.finish();
    pdf.stream(drawing, &packed(&page_content))
        .filter(Filter::FlateDecode);
    for (font, places) in embedded {
        embed(&mut pdf, font, fonts, &used[font], places);
    }
    pdf.finish()
}

fn packed(bytes: &[u8]) -> Vec<u8> {
    let mut encoder = ZlibEncoder::new(Vec::new(), Compression::best());
    let packed = encoder.write_all(bytes).and_then(|()| encoder.finish());
    packed.expect("memory takes all bytes")
}

/// Writes the content stream of the page, with y upwards, and records the glyphs that it uses.
fn content_stream(canvas: &Canvas, used: &mut [UsedGlyphs; 2]) -> Vec<u8> {
    let mut content = Content::new();
    let height = canvas.size[1];
    content.set_line_join(pdf_writer::types::LineJoinStyle::RoundJoin);
    for item in &canvas.items {
        match item {
            Item::Path {
                segments,
                fill,
                pen,
            } => path(&mut content, height, segments, *fill, *pen),
            Item::Text(text) => write_text(&mut content, height, text, used),
        }
    }
    content.finish().to_vec()
}

fn path(
    content: &mut Content,
    height: f64,
    segments: &[Segment],
    fill: Option<Colour>,
    pen: Option<Pen>,
) {
    let rounded = |[x, y]: [f64; 2]| [round_length(x), round_length(height - y)];
    if let Some(colour) = fill {
        let [red, green, blue] = colour.map(share);
        content.set_fill_rgb(red, green, blue);
    }
    if let Some(pen) = pen {
        let [red, green, blue] = pen.colour.map(share);
        content.set_stroke_rgb(red, green, blue);
        content.set_line_width(pen.width as f32);
        content.set_dash_pattern(pen.dash.iter().map(|length| *length as f32), 0.0);
    }
    for segment in segments {
        match segment {
            Segment::Move(at) => {
                let [x, y] = rounded(*at);
                content.move_to(x, y);
            }
            Segment::Line(at) => {
                let [x, y] = rounded(*at);
                content.line_to(x, y);
            }
            Segment::Curve(one, two, at) => {
                let [[x1, y1], [x2, y2], [x, y]] = [*one, *two, *at].map(rounded);
                content.cubic_to(x1, y1, x2, y2, x, y);
            }
            Segment::Close => {
                content.close_path();
            }
        }
    }
    match (fill, pen) {
        (Some(_), Some(_)) => content.fill_nonzero_and_stroke(),
        (Some(_), None) => content.fill_nonzero(),
        (None, Some(_)) => content.stroke(),
        (None, None) => content.end_path(),
    };
}

/// Writes a line of text to the content stream, with one operator for each run of one font, size
/// and level.
fn write_text(content: &mut Content, height: f64, text: &Text, used: &mut [UsedGlyphs; 2]) {
    let [red, green, blue] = BLACK.map(share);
    content.set_fill_rgb(red, green, blue);
    content.begin_text();
    let alike = |a: &super::canvas::Glyph, b: &super::canvas::Glyph| {
        a.font == b.font && a.size == b.size && a.at[1] == b.at[1]
    };
    for run in text.glyphs.chunk_by(alike) {
        let first = run[0];
        let [along, above] = first.at;
        let [x, y] = text.at;
        let matrix = if text.upwards {
            [
                0.0,
                1.0,
                -1.0,
                0.0,
                round_length(x - above),
                round_length(height - y + along),
            ]
        } else {
            [
                1.0,
                0.0,
                0.0,
                1.0,
                round_length(x + along),
                round_length(height - y + above),
            ]
        };
        let mut bytes = Vec::new();
        for glyph in run {
            let used = &mut used[glyph.font];
            let number = used.numbers.remap(glyph.id);
            used.letters.insert(number, glyph.letter);
            bytes.extend(number.to_be_bytes());
        }
        content.set_font(RESOURCES[first.font], round_length(first.size));
        content.set_text_matrix(matrix);
        content.show(Str(&bytes));
    }
    content.end_text();
}

/// Embeds the used subset of a font: font file, descriptor, widths, and the mapping from glyphs to
/// characters.
fn embed(pdf: &mut Pdf, font: usize, fonts: &Fonts, used: &UsedGlyphs, places: [Ref; 5]) {
    let [outer, inner, descriptor, file, letters] = places;
    let face = fonts.face(font);
    let per_em = f32::from(face.units_per_em());
    let scaled = |units: i16| f32::from(units) / per_em * 1000.0;
    // Six letters name a part of a font.
    let name = format!("STOSSZ+{}", NAMES[font]);
    let name = Name(name.as_bytes());
    let system = SystemInfo {
        registry: Str(b"Adobe"),
        ordering: Str(b"Identity"),
        supplement: 0,
    };
    pdf.type0_font(outer)
        .base_font(name)
        .encoding_predefined(Name(b"Identity-H"))
        .descendant_font(inner)
        .to_unicode(letters);
    let mut cid = pdf.cid_font(inner);
    cid.subtype(CidFontType::Type2)
        .base_font(name)
        .system_info(system)
        .font_descriptor(descriptor)
        .default_width(0.0)
        .cid_to_gid_map_predefined(Name(b"Identity"));
    let widths = used.numbers.remapped_gids();
    let widths = widths.map(|id| (1000.0 * fonts.advance(font, id)) as f32);
    cid.widths().consecutive(0, widths);
    cid.finish();
    let bounds = face.global_bounding_box();
    let flags = if font == 1 {
        FontFlags::NON_SYMBOLIC | FontFlags::ITALIC
    } else {
        FontFlags::NON_SYMBOLIC
    };
    pdf.font_descriptor(descriptor)
        .name(name)
        .flags(flags)
        .bbox(Rect::new(
            scaled(bounds.x_min),
            scaled(bounds.y_min),
            scaled(bounds.x_max),
            scaled(bounds.y_max),
        ))
        .italic_angle(face.italic_angle())
        .ascent(scaled(face.ascender()))
        .descent(scaled(face.descender()))
        .cap_height(1000.0 * super::font::CAPITALS as f32)
        .stem_v(80.0)
        .font_file2(file);
    let part = subset(FILES[font], 0, &used.numbers).expect("a font of this crate");
    pdf.stream(file, &packed(&part))
        .filter(Filter::FlateDecode)
        .pair(Name(b"Length1"), part.len() as i32);
    let mut map = UnicodeCmap::new(Name(b"Letters"), system);
    for (number, letter) in &used.letters {
        map.pair(*number, *letter);
    }
    pdf.cmap(letters, &map.finish());
}

fn share(part: u8) -> f32 {
    f32::from(part) / 255.0
}

/// Rounds a length to a hundredth of a point, as in SVG files.
fn round_length(length: f64) -> f32 {
    (100.0 * length).round() as f32 / 100.0
}

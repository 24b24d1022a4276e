// SPDX-License-Identifier: Apache-2.0

// `mtf config import`: what lens programs export becomes a [[presample]] block of a sensor file, or a table over the
// field. Each kind of file has a reader in mtf/io/designs and a row in kDesignKinds. Every block goes through the
// reader of sensor files before it is written, so that its errors and warnings are those that a sensor with it will
// have.

#include <algorithm>
#include <array>
#include <cmath>
#include <filesystem>
#include <map>
#include <numbers>

#include "apps/import/config_import.h"
#include "apps/terminal/output.h"
#include "apps/terminal/output_set.h"
#include "mtf/components/psf.h"
#include "mtf/error.h"
#include "mtf/io/config/config_edit.h"
#include "mtf/io/csv/csv_cells.h"
#include "mtf/io/csv/field_map_csv.h"
#include "mtf/io/csv/spectral_units.h"
#include "mtf/io/designs/design_columns.h"
#include "mtf/io/designs/mtf_listing.h"
#include "mtf/io/designs/psf_fits.h"
#include "mtf/io/designs/psf_listing.h"
#include "mtf/io/designs/zernike_listing.h"

namespace apps {
namespace {

using mtf::io::DesignField;
using mtf::io::DesignRemarks;
using mtf::io::DesignText;
using mtf::io::ZernikeField;
using mtf::io::cfg::toml_number;
using mtf::io::cfg::toml_string;

/// A sensor file is limited, and has more in it than the block.
constexpr std::size_t kMostBlockBytes = mtf::io::cfg::kMaxBytes - (std::size_t{1} << 16);

/// What is written, and what is said of it.
struct Imported {
  std::string text{};
  DesignRemarks remarks{};
};

void add(DesignRemarks& all, const DesignRemarks& more) {
  all.notes.insert(all.notes.end(), more.notes.begin(), more.notes.end());
  all.warnings.insert(all.warnings.end(), more.warnings.begin(), more.warnings.end());
}

/// The field that is asked for, of all that the files have.
template <class Field>
const Field& one_field(const std::vector<Field>& fields, int number) {
  if (number > 0 && number <= std::ssize(fields)) return fields[static_cast<std::size_t>(number - 1)];
  if (number == 0 && fields.size() == 1) return fields.front();
  int count = 0;
  const std::string list = joined(
      fields,
      [&](const Field& field) {
        std::string name = "without a place";
        if constexpr (requires { field.label; }) name = field.label;
        return std::to_string(++count) + ": " + (field.place ? field.place->text() : name);
      },
      "; ");
  throw mtf::UsageError("the files have " + plural(std::ssize(fields), "field") +
                        " (x, y down), and a block holds one: " + list + "; choose by --field 1");
}

std::string block(const std::string& kind, const std::vector<std::string>& keys) {
  return "[[presample]]\nkind = " + toml_string(kind) + "\n" + joined(keys, "\n") + "\n";
}

/// Each line as a comment.
std::string commented(std::string_view text) {
  std::string lines;
  while (!text.empty()) lines += "# " + std::string(mtf::io::take_text_line(text)) + "\n";
  return lines;
}

/// The block as part of a sensor, which is returned. Throws UsageError where the sensor would be refused.
mtf::io::SensorConfig check_block(const std::string& text, double wavelength_um, DesignRemarks& remarks) {
  const std::string sensor =
      "schema = 2\n[frame]\nfocal_length = \"100 mm\"\npitch = \"10 um\"\n[optics]\nf_number = 4.0\nwavelength = " +
      toml_string(mtf::format_double(wavelength_um) + " um") + "\n";
  mtf::io::ConfigResult result = mtf::io::parse_config(sensor + text, "the imported block");
  for (const auto& found : result.diagnostics) {
    const std::string what = found.path + ": " + found.text;
    if (found.error)
      throw mtf::UsageError("a sensor file would refuse what was imported: " + what +
                            joined(
                                remarks.warnings, [](const std::string& line) { return "; " + line; }, ""));
    if (found.path.starts_with("presample[")) remarks.warnings.push_back(what);
  }
  return std::move(result.config);
}

/// Turns wavefronts of fields along one axis so that their x points away from the optical axis, and places to (r, 0).
/// Returns the largest rms of what is then not symmetric about x, in waves: 0 of a lens with an axis.
double turn_outwards(std::vector<ZernikeField>& fields, mtf::ZernikeNumbering numbering) {
  double skew = 0.0;
  const DesignField& last = *std::ranges::max_element(fields, {}, [](const ZernikeField& f) {
                               return std::abs(f.place->x) + std::abs(f.place->y);
                             })->place;
  const mtf::FieldPoint<double> out{last.x == 0.0 ? 0.0 : std::copysign(1.0, last.x),
                                    last.x != 0.0 ? 0.0 : std::copysign(1.0, last.y)};
  for (ZernikeField& field : fields) {
    field.place->x = out.x * field.place->x + out.y * field.place->y;
    field.place->y = 0.0;
    mtf::PupilPolynomial w = mtf::rotated(mtf::io::zernike_sum(numbering, field.waves), out.x, out.y);
    field.waves = mtf::io::zernike_terms(numbering, w);
    for (auto& row : w.a)
      for (std::size_t j = 0; j < row.size(); j += 2) row[j] = 0.0;
    skew = std::max(skew, mtf::io::disc_rms(w));
  }
  return skew;
}

/// Twelve digits; what rounding leaves of 0 is 0.
std::string coefficient(double waves) { return std::abs(waves) < 1e-13 ? "0" : significant(waves, 12); }

/// A table over the field, with the block that names it as comments.
Imported zernike_table(std::vector<ZernikeField> fields, std::vector<std::string> keys, mtf::ZernikeNumbering numbering,
                       const std::string& file) {
  Imported result;
  for (const ZernikeField& field : fields)
    if (!field.place || field.place->unit != fields.front().place->unit)
      throw mtf::UsageError("several fields need a place each, in one unit; or choose one by --field 1");
  const bool radial = std::ranges::all_of(fields, [](const auto& f) { return f.place->x == 0.0; }) ||
                      std::ranges::all_of(fields, [](const auto& f) { return f.place->y == 0.0; });
  if (radial) {
    const double skew = turn_outwards(fields, numbering);
    keys.push_back("orientation = \"field\"");
    result.remarks.notes.push_back(
        "all fields lie on one side of the axis: taken for a lens that is symmetric about it, "
        "x of the wavefront turned to point away from it");
    if (skew > 1e-3)
      result.remarks.warnings.push_back("of the wavefront " + mtf::three_digits(skew) +
                                        " waves rms are not symmetric "
                                        "about that direction: the lens has no axis; export fields all over the image");
  }
  const std::string unit = " (" + fields.front().place->unit + ")";
  std::vector<std::string> rows{radial ? "r" + unit : "x" + unit + ",y" + unit};
  for (ZernikeField& field : fields) {
    if (radial && field.place->x < 0.0)
      throw mtf::UsageError("fields on both sides of the axis, along one line; leave out those of one side");
    rows.push_back(significant(field.place->x, 12) + (radial ? "" : "," + significant(field.place->y, 12)));
    field.waves.resize(static_cast<std::size_t>(mtf::zernike_count(numbering)));
  }
  for (std::size_t term = 3; term < fields.front().waves.size(); ++term) {
    if (std::ranges::all_of(fields, [&](const auto& f) { return coefficient(f.waves[term]) == "0"; })) continue;
    rows[0] += ",Z" + std::to_string(term + 1);
    for (std::size_t i = 0; i < fields.size(); ++i) rows[i + 1] += "," + coefficient(fields[i].waves[term]);
  }
  keys.insert(keys.begin(), "table = " + toml_string(file.empty() ? "zernike.csv" : file.substr(file.rfind('/') + 1)));
  result.text = commented(block("wavefront", keys)) + joined(rows, "\n") + "\n";
  static_cast<void>(mtf::io::parse_field_map_csv(joined(rows, "\n"), "the imported table"));  // as a sensor would
  return result;
}

Imported import_zernike(const std::vector<DesignText>& texts, const ImportOptions& options) {
  std::vector<ZernikeField> fields;
  std::optional<mtf::ZernikeNumbering> numbering;
  DesignRemarks remarks;
  for (const DesignText& text : texts) {
    const mtf::io::ZernikeListing listing = read_zernike_listing(text, options.reading);
    if (numbering.value_or(listing.numbering) != listing.numbering)
      throw mtf::UsageError(text.source + ": another order of terms than " + texts.front().source +
                            "; export them alike");
    numbering = listing.numbering;
    fields.insert(fields.end(), listing.fields.begin(), listing.fields.end());
    add(remarks, listing.remarks);
  }
  for (const ZernikeField& field : fields)
    if (field.wavelength_um != fields.front().wavelength_um)
      throw mtf::UsageError("the fields are of different wavelengths; export them at one");
  remarks.notes.push_back("f-number and obscuration are those of [optics]");
  std::vector<std::string> keys{
      "numbering = " + toml_string(mtf::kNumberingNames[static_cast<std::size_t>(*numbering)]),
      "wavelength_reference = " + toml_string(mtf::format_double(fields.front().wavelength_um) + " um")};
  Imported result;
  if (fields.size() > 1 && options.field == 0) {
    result = zernike_table(std::move(fields), std::move(keys), *numbering, options.out);
  } else {
    const ZernikeField& field = one_field(fields, options.field);
    keys.push_back("zernike = [" + joined(field.waves, toml_number) + "]");
    result.text = block("wavefront", keys);
    check_block(result.text, field.wavelength_um, remarks);
  }
  add(remarks, result.remarks);
  return {std::move(result.text), std::move(remarks)};
}

/// Of a PSF whose samples are rows.
Imported psf_block(const std::vector<std::vector<double>>& samples, std::vector<std::string> keys,
                   DesignRemarks remarks) {
  const auto row = [](const std::vector<double>& numbers) { return "[" + joined(numbers, toml_number, ",") + "]"; };
  keys.push_back("samples = [" + joined(samples, row, ",\n") + "]");
  Imported result{.text = block("psf", keys), .remarks = std::move(remarks)};
  if (result.text.size() > kMostBlockBytes)
    throw mtf::UsageError(mtf::size_text(std::ssize(samples.front()), std::ssize(samples)) +
                          " samples are more than a sensor file holds; export about 256 by 256 with the same spacing");
  check_block(result.text, 1.0, result.remarks);
  return result;
}

Imported import_psf(const std::vector<DesignText>& texts, const ImportOptions& options) {
  std::vector<mtf::io::PsfListing> fields;
  for (const DesignText& text : texts) fields.push_back(read_psf_listing(text, options.reading));
  const mtf::io::PsfListing& psf = one_field(fields, options.field);
  return psf_block(psf.samples, {"step = " + toml_string(mtf::format_double(psf.step_um) + " um"), "part = \"optics\""},
                   psf.remarks);
}

/// What is said to the user, as the first lines of the result.
std::string heading(const DesignRemarks& remarks, const Global& global) {
  std::string head = "# mtf config import\n";
  for (const std::string& line : remarks.notes) head += "# " + one_line(line) + "\n";
  for (const std::string& line : remarks.warnings) head += "# warning: " + one_line(line) + "\n";
  for (const std::string& line : remarks.notes) note(global, one_line(line));
  for (const std::string& line : remarks.warnings) note(global, "warning: " + one_line(line));
  return head;
}

void write_result(const ImportOptions& options, const std::string& text, const Global& global) {
  if (emit_for_editing(options.out, text, options.force)) note(global, "wrote " + one_line(options.out));
}

/// Throws UsageError for the first option that is given and changes nothing of such a file.
void require_effect(const std::string& what, std::initializer_list<std::pair<const char*, bool>> given) {
  for (const auto& [name, is_given] : given)
    if (is_given) throw mtf::UsageError(std::string(name) + " has no effect on " + what + "; leave it out");
}

/// Rows of samples, in the digits of a float.
std::vector<std::vector<double>> rows_of(const mtf::Image& samples) {
  std::vector<std::vector<double>> rows(static_cast<std::size_t>(samples.height()));
  for (std::int64_t i = 0; i < samples.size(); ++i)
    rows[static_cast<std::size_t>(i / samples.width())].push_back(
        *mtf::io::cell_number(mtf::io::number_text(samples.data()[i])));
  return rows;
}

/// What a sensor would say of the point spread of each place. Throws UsageError for one that it would refuse; of
/// warnings of one kind the first is added, and how many places have it.
void check_places(const std::vector<mtf::io::PsfPlane>& planes, const std::string& step, DesignRemarks& remarks) {
  DesignRemarks of_one_sample;
  const mtf::System<double> system = check_block(block("psf", {step, "samples = [[1.0]]"}), 1.0, of_one_sample).system;
  mtf::Psf<double> psf =
      *system.list(mtf::Stage::presample).front().component.get_if<mtf::Psf<double>>();  // with the step as it is read
  std::map<std::string, std::pair<std::string, std::int64_t>> warnings;
  for (const mtf::io::PsfPlane& plane : planes) {
    psf.samples = rows_of(plane.samples);
    for (const mtf::Problem& problem : psf.check(system.context())) {
      const std::string text =
          "the point spread of " + plane.place->text() + ": " + problem.field + ": " + problem.text;
      if (problem.error) throw mtf::UsageError("a sensor file would refuse what was imported: " + text);
      ++warnings.try_emplace(problem.field, text, 0).first->second.second;
    }
  }
  for (const auto& [field, warning] : warnings)
    remarks.warnings.push_back(warning.first + "; so it is with " + plural(warning.second, "place") + " of " +
                               std::to_string(planes.size()));
}

/// One point spread is a block; those of several places are images beside the table that names them.
void import_fits(const ImportOptions& options, const Global& global) {
  const std::string& file = options.files.front();
  require_effect(file + ", a FITS", {{"--as", !options.kind.empty() && options.kind != "psf"},
                                     {"--columns", !options.columns.empty()},
                                     {"--order", options.reading.order.has_value()},
                                     {"--sign", options.reading.sign != 1.0}});
  if (options.files.size() > 1) throw mtf::UsageError("one FITS at a time: leave out " + options.files[1]);
  mtf::io::PsfFits psf = read_psf_fits(file, options.fits);
  const std::string step = "step = " + toml_string(psf.step);
  const bool one = options.field > 0 || !psf.planes.front().place;
  if (one) {
    const mtf::io::PsfPlane& plane = one_field(psf.planes, options.field);
    psf.remarks.notes.push_back(plane.place ? plane.place->text() : plane.label);
    const Imported made = psf_block(rows_of(plane.samples), {step}, psf.remarks);
    return write_result(options, heading(made.remarks, global) + made.text, global);
  }
  if (!options.out.ends_with(".csv"))
    throw mtf::UsageError(plural(std::ssize(psf.planes), "place") +
                          " make a table with images beside it: -o psfs.csv; or choose one by --field 1");
  check_places(psf.planes, step, psf.remarks);
  std::vector<std::string> files{options.out};
  const auto base = [](const std::string& path) { return path.substr(path.rfind('/') + 1); };
  std::string rows =
      commented(block("psf", {step, "positions = " + toml_string(base(options.out))})) + "x (px),y (px),file\n";
  std::string places = "x (px),y (px),plane";
  for (const mtf::io::PsfPlane& one_of : psf.planes) {
    files.push_back(options.out.substr(0, options.out.size() - 4) + "_" + std::to_string(files.size()) + ".exr");
    const std::string place = mtf::format_double(one_of.place->x) + "," + mtf::format_double(one_of.place->y) + ",";
    rows += place + mtf::io::csv_field(base(files.back())) + "\n";
    places += "\n" + place + "1";
  }
  static_cast<void>(mtf::io::parse_field_map_csv(places, "the imported table"));  // as a sensor would
  for (const std::string& name : files)
    if (!options.force && std::filesystem::exists(name))
      throw mtf::UsageError(name + ": exists already; --force replaces it, -o NAME writes another file");
  OutputSet output({.files = files, .inputs = options.files});
  for (std::size_t i = 1; i < files.size(); ++i)
    mtf::io::write_exr(output.at(files[i]), {{"Y", psf.planes[i - 1].samples.view()}}, {});
  output.commit(options.out, heading(psf.remarks, global) + rows);
  note(global, "wrote " + one_line(options.out) + " and " + plural(std::ssize(psf.planes), "image"));
}

Imported import_mtf(const std::vector<DesignText>& texts, const ImportOptions& options) {
  std::vector<mtf::io::MtfField> fields;
  std::string unit;
  DesignRemarks remarks;
  for (const DesignText& text : texts) {
    const mtf::io::MtfListing listing = read_mtf_listing(text, options.reading);
    if (!unit.empty() && unit != listing.unit) throw mtf::UsageError("the files differ in the unit of frequency");
    unit = listing.unit;
    fields.insert(fields.end(), listing.fields.begin(), listing.fields.end());
    add(remarks, listing.remarks);
  }
  const mtf::io::MtfField& field = one_field(fields, options.field);
  const double x = field.place ? field.place->x : 0.0, y = field.place ? field.place->y : 0.0;
  if (x != 0.0 && y != 0.0)
    throw mtf::UsageError("the field " + field.place->text() +
                          " lies along neither x nor y, and `curve` has no other "
                          "direction; turn the lens, or import a PSF of this field");
  const bool along_x = x != 0.0;
  const auto curve = [&](const char* axis, const std::vector<double>& mtf) {
    std::string lines = "file = \"\"\"\nfrequency_" + mtf::io::plain_words(unit) + ",mtf\n";
    for (std::size_t i = 0; i < mtf.size(); ++i)
      lines += mtf::format_double(field.frequency[i]) + "," + mtf::format_double(mtf[i]) + "\n";
    return block("curve", {std::string("axis = \"") + axis + "\"", "part = \"optics\"", lines + "\"\"\""});
  };
  double apart = 0.0;
  for (std::size_t i = 0; i < field.frequency.size(); ++i)
    apart = std::max(apart, std::abs(field.tangential[i] - field.sagittal[i]));
  Imported result;
  if (apart <= 2e-3) {  // three digits each
    result.text = curve("radial", field.tangential);
    remarks.notes.push_back("both cuts are alike: one radial curve");
  } else {
    const mtf::Unit& cycles = *mtf::find_unit(unit);
    const mtf::Curve t = mtf::make_curve("the tangential cut", cycles, field.frequency, field.tangential),
                     s = mtf::make_curve("the sagittal cut", cycles, field.frequency, field.sagittal);
    // Between its axes the product of the cuts, against what goes from one to the other with the angle.
    double between = 0.0;
    for (const double f : field.frequency) {
      const double diagonal = f * std::numbers::sqrt2 / 2.0;
      between = std::max(between, std::abs(evaluate(t, diagonal).value * evaluate(s, diagonal).value -
                                           0.5 * (evaluate(t, f).value + evaluate(s, f).value)));
    }
    result.text = curve(along_x ? "x" : "y", field.tangential) + curve(along_x ? "y" : "x", field.sagittal);
    remarks.notes.push_back(std::string("the tangential cut is taken along ") + (along_x ? "x" : "y"));
    remarks.warnings.push_back(
        "off its two cuts the MTF is not known; their product, which is taken, and their mean "
        "differ by up to " +
        mtf::three_digits(between) + " on the diagonals");
  }
  check_block(result.text, 1.0, remarks);
  return {std::move(result.text), std::move(remarks)};
}

/// A kind of file: how it is told, what it is called, what becomes of it.
struct DesignKind {
  std::string_view name, what;
  bool (*is)(const DesignText&);
  Imported (*import)(const std::vector<DesignText>&, const ImportOptions&);
};
constexpr std::array kDesignKinds{
    DesignKind{"zernike", "Zernike Standard or Fringe coefficients, or a table of them (columns Z4 (waves), ...)",
               mtf::io::is_zernike_listing, import_zernike},
    DesignKind{"psf", "an FFT or Huygens PSF of OpticStudio", mtf::io::is_psf_listing, import_psf},
    DesignKind{"mtf", "an MTF against frequency (columns tangential, sagittal, or RAD, TAN)", mtf::io::is_mtf_listing,
               import_mtf}};

const DesignKind& kind_of(const DesignText& text, const std::string& wanted) {
  const auto* kind = std::ranges::find_if(
      kDesignKinds, [&](const DesignKind& k) { return wanted.empty() ? k.is(text) : k.name == wanted; });
  if (kind == kDesignKinds.end() || !kind->is(text))
    throw mtf::UsageError(text.source + ": not " +
                          (kind == kDesignKinds.end() ? "a listing that is read" : std::string(kind->what)) +
                          "; read are the texts of these analyses, as a lens program saves them, not its lens files: " +
                          joined(
                              kDesignKinds, [](const DesignKind& k) { return std::string(k.what); }, "; "));
  return *kind;
}

}  // namespace

int run_config_import(const ImportOptions& given, const Global& global) {
  ImportOptions options = given;
  if (mtf::io::is_fits(options.files.front())) {
    options.fits.y_up = options.reading.y_up;
    import_fits(options, global);
    return 0;
  }
  std::vector<DesignText> texts;
  DesignRemarks remarks;
  for (const std::string& file : options.files) {
    DesignText text = mtf::io::read_design_text(file);
    const std::string columns = options.columns.empty() ? mtf::io::field_scan_columns(text) : options.columns;
    if (options.columns.empty() && !columns.empty() && text.has("Fringe") != text.has("Standard"))
      text.order = text.has("Fringe") ? "fringe" : "noll";
    if (options.columns.empty() && !columns.empty())
      remarks.notes.push_back(file +
                              ": the fields are taken along +y, the preset scan; another one is for --columns to say");
    texts.push_back(columns.empty() ? std::move(text) : with_columns(text, columns, remarks));
  }
  const DesignKind& kind = kind_of(texts.front(), options.kind);
  const bool has_waves = kind.name == "zernike";
  require_effect(texts.front().source, {{"--detector", options.fits.detector.has_value()},
                                        {"--step", !options.fits.step.empty()},
                                        {"--order", !has_waves && options.reading.order},
                                        {"--sign", !has_waves && options.reading.sign != 1.0}});
  for (const DesignText& text : texts) {
    static_cast<void>(kind_of(text, std::string(kind.name)));
    remarks.notes.push_back(text.source + ": " + std::string(kind.what) + ", in " + text.encoding +
                            (text.decimal_comma ? ", with decimal commas" : ""));
  }
  const Imported result = kind.import(texts, options);
  add(remarks, result.remarks);
  write_result(options, heading(remarks, global) + result.text, global);
  return 0;
}

}  // namespace apps

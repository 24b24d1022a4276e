// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/codecs/drawing.h"

#include <algorithm>
#include <cmath>
#include <string_view>

#include "mtf/io/codecs/codecs.h"

namespace mtf::io {
namespace {

/// Simplex Roman, the letters of ASCII from the blank on, `|` behind each: its left and its right end, then points, a
/// pair of characters each, whose distances from R are x to the right and y down; a blank lifts the pen. The Hershey
/// Fonts were originally created by Dr. A. V. Hershey while working at the U. S. National Bureau of Standards; this
/// format by James Hurt, Cognition, Inc., 900 Technology Park Drive, Billerica, MA 01821. The caret is ours: theirs is
/// an arrow.
constexpr std::string_view kGlyphs = R"(
JZ|MWRFRT RRYQZR[SZRY|JZNFNM RVFVM|H]SBLb RYBRb RLOZO RKUYU|H\PBP_ RTBT_ RYIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZ
KX|F^[FI[ RNFPHPJOLMMKMIKIIJGLFNFPGSHVHYG[F RWTUUTWTYV[X[ZZ[X[VYTWT|E_\O\N[MZMYNXPVUTXRZP[L[JZIYHWHUISJRQNRMSKSI
RGPFNGMIMKNNPQUXWZY[[[\Z\Y|MWRHQGRFSGSIRKQL|KYVBTDRGPKOPOTPYR]T`Vb|KYNBPDRGTKUPUTTYR]P`Nb|JZRFRR RMIWO RWIMO|E_R
IR[ RIR[R|MWSZR[QZRYSZS\R^Q_|E_IR[R|MWRYQZR[SZRY|G][BIb|H\QFNGLJKOKRLWNZQ[S[VZXWYRYOXJVGSFQF|H\NJPISFS[|H\LKLJMH
NGPFTFVGWHXJXLWNUQK[Y[|H\MFXFRNUNWOXPYSYUXXVZS[P[MZLYKW|H\UFKTZT RUFU[|H\WFMFLOMNPMSMVNXPYSYUXXVZS[P[MZLYKW|H\XI
WGTFRFOGMJLOLTMXOZR[S[VZXXYUYTXQVOSNRNOOMQLT|H\YFO[ RKFYF|H\PFMGLILKMMONSOVPXRYTYWXYWZT[P[MZLYKWKTLRNPQOUNWMXKXI
WGTFPF|H\XMWPURRSQSNRLPKMKLLINGQFRFUGWIXMXRWWUZR[P[MZLX|MWRMQNROSNRM RRYQZR[SZRY|MWRMQNROSNRM RSZR[QZRYSZS\R^Q_|
F^ZIJRZ[|E_IO[O RIU[U|F^JIZRJ[|I[LKLJMHNGPFTFVGWHXJXLWNVORQRT RRYQZR[SZRY|E`WNVLTKQKOLNMMPMSNUPVSVUUVS RQKOMNPNS
OUPV RWKVSVUXVZV\T]Q]O\L[JYHWGTFQFNGLHJJILHOHRIUJWLYNZQ[T[WZYYZX RXKWSWUXV|I[RFJ[ RRFZ[ RMTWT|G\KFK[ RKFTFWGXHYJ
YLXNWOTP RKPTPWQXRYTYWXYWZT[K[|H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZV|G\KFK[ RKFRFUGWIXKYNYSXVWXUZR[K[|H[LFL[ RL
FYF RLPTP RL[Y[|HZLFL[ RLFYF RLPTP|H]ZKYIWGUFQFOGMILKKNKSLVMXOZQ[U[WZYXZVZS RUSZS|G]KFK[ RYFY[ RKPYP|NVRFR[|JZVF
VVUYTZR[P[NZMYLVLT|G\KFK[ RYFKT RPOY[|HYLFL[ RL[X[|F^JFJ[ RJFR[ RZFR[ RZFZ[|G]KFK[ RKFY[ RYFY[|G]PFNGLIKKJNJSKVL
XNZP[T[VZXXYVZSZNYKXIVGTFPF|G\KFK[ RKFTFWGXHYJYMXOWPTQKQ|G]PFNGLIKKJNJSKVLXNZP[T[VZXXYVZSZNYKXIVGTFPF RSWY]|G\KF
K[ RKFTFWGXHYJYLXNWOTPKP RRPY[|H\YIWGTFPFMGKIKKLMMNOOUQWRXSYUYXWZT[P[MZKX|JZRFR[ RKFYF|G]KFKULXNZQ[S[VZXXYUYF|I[
JFR[ RZFR[|F^HFM[ RRFM[ RRFW[ R\FW[|H\KFY[ RYFK[|I[JFRPR[ RZFRP|H\YFK[ RKFYF RK[Y[|KYOBOb RPBPb ROBVB RObVb|KYKF
Y^|KYTBTb RUBUb RNBUB RNbUb|JZNLRFVL|JZJ]Z]|MWSFRGQIQKRLSKRJ|I\XMX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX|H[LFL[ RLPNNPM
SMUNWPXSXUWXUZS[P[NZLX|I[XPVNTMQMONMPLSLUMXOZQ[T[VZXX|I\XFX[ RXPVNTMQMONMPLSLUMXOZQ[T[VZXX|I[LSXSXQWOVNTMQMONMPL
SLUMXOZQ[T[VZXX|MYWFUFSGRJR[ ROMVM|I\XMX]W`VaTbQbOa RXPVNTMQMONMPLSLUMXOZQ[T[VZXX|I\MFM[ RMQPNRMUMWNXQX[|NVQFRGS
FREQF RRMR[|MWRFSGTFSERF RSMS^RaPbNb|IZMFM[ RWMMW RQSX[|NVRFR[|CaGMG[ RGQJNLMOMQNRQR[ RRQUNWMZM\N]Q][|I\MMM[ RMQ
PNRMUMWNXQX[|I\QMONMPLSLUMXOZQ[T[VZXXYUYSXPVNTMQM|H[LMLb RLPNNPMSMUNWPXSXUWXUZS[P[NZLX|I\XMXb RXPVNTMQMONMPLSLUM
XOZQ[T[VZXX|KXOMO[ ROSPPRNTMWM|J[XPWNTMQMNNMPNRPSUTWUXWXXWZT[Q[NZMX|MYRFRWSZU[W[ ROMVM|I\MMMWNZP[S[UZXW RXMX[|JZ
LMR[ RXMR[|G]JMN[ RRMN[ RRMV[ RZMV[|J[MMX[ RXMM[|JZLMR[ RXMR[P_NaLbKb|J[XMM[ RMMXM RM[X[|KYTBRCQDPFPHQJRKSMSOQ
Q RRCQEQGRISJTLTNSPORSTTVTXSZR[Q]Q_Ra RQSSUSWRYQZP\P^Q`RaTb|NVRBRb|KYPBRCSDTFTHSJRKQMQOSQ RRCSESGRIQJPLPNQPURQTP
VPXQZR[S]S_Ra RSSQUQWRYSZT\T^S`RaPb|F^IUISJPLONOPPTSVTXTZS[Q RISJQLPNPPQTTVUXUZT[Q[O|)";
constexpr double kBaseLine = 9.0;  // y of the foot of letters
constexpr double kUnit = 0.4;      // pixels of the picture for a caption of size 1
constexpr double kPen = 1.5;       // width of lines in pixels of the picture

/// Every fifth of the 256 colours of inferno (S. van der Walt and N. Smith, 2015, CC0), RRGGBB.
constexpr std::string_view kInferno =
    "00000402020c0504170a072210092d160b391e0c45260c512f0a5b380962400a67490b6a510e6c59106e61136e69166e71196e781c6d801f6c"
    "88226a902568982766a02a63a82e5fb0315bb73557bf3952c63d4dcc4248d34743d94d3ddf5337e45a31e9612bed6925f1711ff47918f78212"
    "f98b0bfa9407fb9d07fca60cfcb014fbba1ffac42af8cd37f6d746f4e156f2ea69f2f27df5f992fcffa4";
constexpr double kInfernoStep = 5.0;

struct Place {
  double x, y;
};
using Line = std::vector<Place>;

double distance(const Place& p, const Place& a, const Place& b) {
  const double dx = b.x - a.x, dy = b.y - a.y, square = dx * dx + dy * dy;
  const double t = square > 0.0 ? std::clamp(((p.x - a.x) * dx + (p.y - a.y) * dy) / square, 0.0, 1.0) : 0.0;
  return std::hypot(p.x - a.x - t * dx, p.y - a.y - t * dy);
}

/// Round ends and joints; pixels that the rim crosses are mixed by how much of them it covers.
void draw_line(const Line& line, const Colour& colour, double width, RasterData& picture) {
  const double reach = 0.5 * width + 0.5;
  const auto bounds = [&](double from, double to, std::int64_t size) {
    const auto pixel = [&](double at) { return static_cast<std::int64_t>(std::clamp(at, 0.0, double(size))); };
    return std::pair{pixel(std::min(from, to) - reach), pixel(std::ceil(std::max(from, to) + reach))};
  };
  for (std::size_t i = 1; i < line.size(); ++i) {
    const Place &a = line[i - 1], &b = line[i];
    const auto [left, right] = bounds(a.x, b.x, picture.width);
    const auto [top, bottom] = bounds(a.y, b.y, picture.height);
    for (std::int64_t y = top; y < bottom; ++y)
      for (std::int64_t x = left; x < right; ++x) {
        const double share = std::min(1.0, reach - distance({double(x) + 0.5, double(y) + 0.5}, a, b));
        if (!(share > 0.0)) continue;
        std::uint16_t* pixel = picture.samples.data() + 3 * (y * picture.width + x);
        for (std::size_t c = 0; c < 3; ++c)
          pixel[c] = static_cast<std::uint16_t>(std::lround(pixel[c] + share * (colour[c] - double(pixel[c]))));
      }
  }
}

/// Lines of the words with the left end of their base line at (0, 0), and their length.
std::pair<std::vector<Line>, double> letters(const std::string& text, double scale) {
  std::vector<std::string_view> glyphs;
  for (std::size_t from = 1; from < kGlyphs.size(); from = kGlyphs.find('|', from) + 1)
    glyphs.push_back(kGlyphs.substr(from, kGlyphs.find('|', from) - from));
  std::vector<Line> lines;
  double x = 0.0;
  for (const char letter : text) {
    const auto code = static_cast<std::size_t>(static_cast<unsigned char>(letter)) - ' ';
    std::string points;
    for (const char c : glyphs[code < glyphs.size() ? code : std::size_t{'?' - ' '}])
      if (c != '\n') points += c;
    const auto at = [&](std::size_t i) { return scale * (points[i] - 'R'); };
    x -= at(0);
    lines.emplace_back();
    for (std::size_t i = 2; i + 1 < points.size(); i += 2) {
      if (points[i] == ' ')
        lines.emplace_back();
      else
        lines.back().push_back({x + at(i), at(i + 1) - scale * kBaseLine});
    }
    x += at(1);
  }
  return {lines, x};
}

void write(const Caption& caption, int zoom, RasterData& picture) {
  auto [lines, length] = letters(caption.text, kUnit * caption.size);
  const double thickness = std::max(kPen, 1.2 * caption.size);
  for (Line& line : lines)
    for (Place& place : line)
      place = {place.x + caption.x * zoom - caption.alignment * length, place.y + caption.y * zoom};
  // A dark rim keeps the words readable on any ground.
  for (const Line& line : lines) draw_line(line, {0, 0, 0}, thickness + 2.0, picture);
  for (const Line& line : lines) draw_line(line, caption.colour, thickness, picture);
}

/// A grey value of 0 to 255.
Colour inferno(int grey) {
  const double at = grey / kInfernoStep;
  const auto digit = [](char c) { return c <= '9' ? c - '0' : c - 'a' + 10; };
  const auto part = [&](std::size_t entry, std::size_t c) {
    return 16 * digit(kInferno[6 * entry + 2 * c]) + digit(kInferno[6 * entry + 2 * c + 1]);
  };
  const auto low = static_cast<std::size_t>(at), high = std::min(low + 1, kInferno.size() / 6 - 1);
  Colour colour{};
  for (std::size_t c = 0; c < 3; ++c)
    colour[c] = static_cast<std::uint8_t>(
        std::lround(part(low, c) + (at - static_cast<double>(low)) * (part(high, c) - part(low, c))));
  return colour;
}

}  // namespace

RasterData drawn(const RasterData& data, const Drawing& drawing) {
  RasterData picture = data;
  picture.width *= drawing.zoom;
  picture.height *= drawing.zoom;
  picture.samples.resize(static_cast<std::size_t>(3 * picture.width * picture.height));
  std::uint16_t* to = picture.samples.data();
  for (std::int64_t y = 0; y < picture.height; ++y)
    for (std::int64_t x = 0; x < picture.width; ++x, to += 3) {
      const std::uint16_t* from = data.samples.data() + 3 * (y / drawing.zoom * data.width + x / drawing.zoom);
      std::copy(from, from + 3, to);
      if (!drawing.false_colour) continue;
      const Colour colour = inferno(*from);
      std::copy(colour.begin(), colour.end(), to);
    }
  for (const Stroke& stroke : drawing.strokes) {
    Line line;
    for (const auto& [x, y] : stroke.points) line.push_back({x * drawing.zoom, y * drawing.zoom});
    draw_line(line, stroke.colour, kPen, picture);
  }
  for (const Caption& caption : drawing.captions) write(caption, drawing.zoom, picture);
  return picture;
}

}  // namespace mtf::io

// SPDX-License-Identifier: Apache-2.0
#include <png.h>
#include <zlib.h>

#include <algorithm>
#include <csetjmp>
#include <cstdlib>
#include <cstring>

#include "mtf/io/codecs/codecs_parts.h"
#include "mtf/io/codecs/raster_scan.h"

namespace mtf::io::module {
namespace {

struct Output {
  int descriptor = -1;
  int error = 0;
};

void write_bytes(png_structp png, png_bytep bytes, png_size_t size) {
  auto& output = *static_cast<Output*>(png_get_io_ptr(png));
  output.error = write_all(output.descriptor, bytes, size);
  if (output.error != 0) png_error(png, "write failed");
}

void on_error(png_structp png, png_const_charp) { png_longjmp(png, 1); }
void on_warning(png_structp, png_const_charp) {}

// Text chunks; anything beyond ASCII goes as UTF-8. Keys are 1 to 79 bytes in this format.
std::vector<png_text> text_chunks(const RasterData& data, std::vector<std::string>& keys) {
  keys.reserve(data.text.size());
  std::vector<png_text> chunks;
  for (const auto& [key, text] : data.text) {
    keys.push_back(key.substr(0, 79));
    const bool ascii = std::all_of(text.begin(), text.end(), [](char c) { return static_cast<signed char>(c) >= 0; });
    png_text chunk{};
    chunk.compression = ascii ? PNG_TEXT_COMPRESSION_NONE : PNG_ITXT_COMPRESSION_NONE;
    chunk.key = keys.back().data();
    chunk.text = const_cast<char*>(text.c_str());
    (ascii ? chunk.text_length : chunk.itxt_length) = text.size();
    chunks.push_back(chunk);
  }
  return chunks;
}

/// Whether a 16-bit image has noise, by three of its rows: values that lie off the line of their neighbours and differ
/// from those above. There a search for repetitions takes twice the time for 3 % of the size; elsewhere it may save
/// most.
bool is_noisy(const RasterData& data) {
  if (data.bits != 16 || data.height < 4) return false;
  const std::int64_t step = data.colours, samples = data.width * step;
  std::int64_t uneven = 0;
  for (const std::int64_t y : {data.height / 4, data.height / 2, 3 * data.height / 4}) {
    const std::uint16_t *const row = data.samples.data() + y * samples, *const above = row - samples;
    for (std::int64_t x = step; x + step < samples; ++x) {
      const int bend = int{row[x - step]} - 2 * int{row[x]} + int{row[x + step]};
      uneven += std::abs(bend) > 2 && row[x] != above[x] ? 1 : 0;
    }
  }
  return uneven > samples;  // a third of them
}

// No object with a destructor lives in here: libpng leaves by longjmp.
bool encode(png_structp png, png_infop info, const RasterData& data, png_text* chunks, int chunk_count,
            unsigned char* row_bytes) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_compression_level(png, 4);
  if (is_noisy(data)) png_set_compression_strategy(png, Z_RLE);
  png_set_IHDR(png, info, static_cast<png_uint_32>(data.width), static_cast<png_uint_32>(data.height), data.bits,
               data.colours == 3 ? PNG_COLOR_TYPE_RGB : PNG_COLOR_TYPE_GRAY, PNG_INTERLACE_NONE,
               PNG_COMPRESSION_TYPE_DEFAULT, PNG_FILTER_TYPE_DEFAULT);
  if (chunk_count > 0) png_set_text(png, info, chunks, chunk_count);
  png_write_info(png, info);
  const std::int64_t row_samples = data.width * data.colours;
  for (std::int64_t y = 0; y < data.height; ++y) {
    const std::uint16_t* row = data.samples.data() + y * row_samples;
    for (std::int64_t i = 0; i < row_samples; ++i) {
      if (data.bits == 8) {
        row_bytes[i] = static_cast<unsigned char>(row[i]);
      } else {
        row_bytes[2 * i] = static_cast<unsigned char>(row[i] >> 8U);
        row_bytes[2 * i + 1] = static_cast<unsigned char>(row[i] & 0xffU);
      }
    }
    png_write_row(png, row_bytes);
  }
  png_write_end(png, info);
  return true;
}

struct Input {
  const unsigned char* next;
  std::size_t left;
};

void read_bytes(png_structp png, png_bytep bytes, png_size_t size) {
  auto& input = *static_cast<Input*>(png_get_io_ptr(png));
  if (size > input.left) png_error(png, "it ends early");
  std::memcpy(bytes, input.next, size);
  input.next += size;
  input.left -= size;
}

// Counts as they are stored, palettes as their colours, without alpha. As above, nothing in here has a destructor.
bool decode(png_structp png, png_infop info, std::size_t row_bytes, png_bytepp rows) {
  if (setjmp(png_jmpbuf(png)) != 0) return false;
  png_set_user_limits(png, 1U << 20U, 1U << 20U);
  png_read_info(png, info);
  png_set_packing(png);
  if (png_get_color_type(png, info) == PNG_COLOR_TYPE_PALETTE) png_set_palette_to_rgb(png);
  png_set_strip_alpha(png);
  png_set_swap(png);  // to the order of this machine, an x86
  static_cast<void>(png_set_interlace_handling(png));
  png_read_update_info(png, info);
  if (png_get_rowbytes(png, info) != row_bytes) return false;
  png_read_image(png, rows);
  png_read_end(png, nullptr);
  return true;
}

}  // namespace

std::vector<Image> decode_png(const std::string& path, std::istream& from, std::int64_t bytes,
                              const RasterHeader& header) {
  std::vector<unsigned char> file;
  require_same(scan_png(path, from, bytes, &file), header, path, "PNG");
  const std::int64_t row_samples = header.width * header.colours;
  const auto row_bytes = static_cast<std::size_t>(row_samples * (header.type == "uint16" ? 2 : 1));
  std::vector<unsigned char> pixels(row_bytes * static_cast<std::size_t>(header.height));
  std::vector<png_bytep> rows;
  for (std::size_t y = 0; y < static_cast<std::size_t>(header.height); ++y)
    rows.push_back(pixels.data() + y * row_bytes);
  Input input{file.data(), file.size()};
  png_structp png = png_create_read_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info != nullptr) png_set_read_fn(png, &input, read_bytes);
  const bool ok = info != nullptr && decode(png, info, row_bytes, rows.data());
  png_destroy_read_struct(&png, &info, nullptr);
  if (!ok) undecodable(path, "PNG", "");
  std::vector<Image> planes = empty_planes(header);
  place({pixels.data(), 0, 0, header.width, header.height, row_samples, header.colours}, header, planes);
  mark_no_data(header, planes);
  return planes;
}

int encode_png(int descriptor, const RasterData& data) {
  Output output{descriptor, 0};
  std::vector<std::string> keys;
  std::vector<png_text> chunks = text_chunks(data, keys);
  std::vector<unsigned char> row(static_cast<std::size_t>(data.width * data.colours * (data.bits / 8)));
  png_structp png = png_create_write_struct(PNG_LIBPNG_VER_STRING, nullptr, on_error, on_warning);
  png_infop info = png != nullptr ? png_create_info_struct(png) : nullptr;
  if (info == nullptr) {
    png_destroy_write_struct(&png, nullptr);
    return ENOMEM;
  }
  png_set_write_fn(png, &output, write_bytes, nullptr);
  const bool ok = encode(png, info, data, chunks.data(), static_cast<int>(chunks.size()), row.data());
  png_destroy_write_struct(&png, &info);
  return output.error != 0 ? output.error : (ok ? 0 : EIO);
}

}  // namespace mtf::io::module

// SPDX-License-Identifier: Apache-2.0
#include "mtf/io/sha256.h"

#include <array>
#include <bit>
#include <cstdint>
#include <fstream>

#include "mtf/error.h"
#include "mtf/io/file_checks.h"

namespace mtf::io {
namespace {

constexpr int kRounds = 64;

// The round constants are the first 32 bits of the fractional parts of the roots of the first primes: computed here in
// integers, which is shorter than the table and cannot hold a typing error.
__extension__ using Wide = unsigned __int128;

constexpr bool is_prime(std::uint32_t n) {
  for (std::uint32_t d = 2; d * d <= n; ++d)
    if (n % d == 0) return false;
  return true;
}

/// floor(2^32 x root) mod 2^32 of the square (power 2) or cube (power 3) root of p.
constexpr std::uint32_t root_fraction(std::uint32_t p, int power) {
  std::uint64_t root = 0;  // of p x 2^(32 power)
  const Wide target = Wide{p} << (32 * power);
  for (int bit = 36; bit >= 0; --bit) {
    const std::uint64_t trial = root | (std::uint64_t{1} << bit);
    const Wide raised = power == 2 ? Wide{trial} * trial : Wide{trial} * trial * trial;
    if (raised <= target) root = trial;
  }
  return static_cast<std::uint32_t>(root);
}

template <std::size_t N>
constexpr std::array<std::uint32_t, N> root_fractions(int power) {
  std::array<std::uint32_t, N> result{};
  std::uint32_t prime = 2;
  for (std::uint32_t& value : result) {
    while (!is_prime(prime)) ++prime;
    value = root_fraction(prime++, power);
  }
  return result;
}

constexpr auto kConstants = root_fractions<kRounds>(3);

void add_block(std::array<std::uint32_t, 8>& state, const unsigned char* block) {
  std::array<std::uint32_t, kRounds> w{};
  for (std::size_t i = 0; i < 16; ++i)
    for (std::size_t k = 0; k < 4; ++k) w[i] = w[i] << 8 | block[4 * i + k];
  for (std::size_t i = 16; i < kRounds; ++i) {
    const std::uint32_t s0 = std::rotr(w[i - 15], 7) ^ std::rotr(w[i - 15], 18) ^ (w[i - 15] >> 3);
    const std::uint32_t s1 = std::rotr(w[i - 2], 17) ^ std::rotr(w[i - 2], 19) ^ (w[i - 2] >> 10);
    w[i] = w[i - 16] + s0 + w[i - 7] + s1;
  }
  auto [a, b, c, d, e, f, g, h] = state;
  for (std::size_t i = 0; i < kRounds; ++i) {
    const std::uint32_t big1 = std::rotr(e, 6) ^ std::rotr(e, 11) ^ std::rotr(e, 25);
    const std::uint32_t t1 = h + big1 + ((e & f) ^ (~e & g)) + kConstants[i] + w[i];
    const std::uint32_t big0 = std::rotr(a, 2) ^ std::rotr(a, 13) ^ std::rotr(a, 22);
    const std::uint32_t t2 = big0 + ((a & b) ^ (a & c) ^ (b & c));
    h = g, g = f, f = e, e = d + t1, d = c, c = b, b = a, a = t1 + t2;
  }
  const std::array<std::uint32_t, 8> sum{a, b, c, d, e, f, g, h};
  for (std::size_t i = 0; i < 8; ++i) state[i] += sum[i];
}

/// Bytes come in pieces; whole blocks are worked off at once.
class Digest {
 public:
  void add(std::string_view bytes) {
    length_ += bytes.size();
    rest_ += bytes;
    const std::size_t whole = rest_.size() / kBlock * kBlock;
    for (std::size_t i = 0; i < whole; i += kBlock)
      add_block(state_, reinterpret_cast<const unsigned char*>(rest_.data()) + i);
    rest_.erase(0, whole);
  }

  std::string hex() {
    const std::uint64_t bits = length_ * 8;
    std::string padding = "\x80";
    padding.append((2 * kBlock - 8 - (rest_.size() + 1) % kBlock) % kBlock, '\0');
    for (int shift = 56; shift >= 0; shift -= 8) padding += static_cast<char>(bits >> shift & 0xff);
    add(padding);
    std::string text;
    for (const std::uint32_t word : state_)
      for (int shift = 28; shift >= 0; shift -= 4) text += "0123456789abcdef"[word >> shift & 0xf];
    return text;
  }

 private:
  static constexpr std::size_t kBlock = 64;
  std::array<std::uint32_t, 8> state_ = root_fractions<8>(2);
  std::string rest_;
  std::uint64_t length_ = 0;
};

}  // namespace

std::string sha256_hex(std::string_view bytes) {
  Digest digest;
  digest.add(bytes);
  return digest.hex();
}

std::string sha256_file(const std::string& path) {
  static_cast<void>(ordinary_file_size(path));
  std::ifstream file(path, std::ios::binary);
  std::string piece(std::size_t{1} << 20, '\0');
  Digest digest;
  while (file.good()) {
    file.read(piece.data(), static_cast<std::streamsize>(piece.size()));
    digest.add(std::string_view(piece).substr(0, static_cast<std::size_t>(file.gcount())));
  }
  if (!file.eof()) throw RuntimeError("cannot read " + path + "; check the path and its permissions");
  return digest.hex();
}

}  // namespace mtf::io

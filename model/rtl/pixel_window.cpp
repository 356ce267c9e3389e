#include "rtl/pixel_window.h"

#include <algorithm>

#include "datapath/composer_buffer.h"

namespace metabuffer::rtl {
namespace {

constexpr std::int64_t kNone = Segment::kNoPixel;
constexpr int kWordBits = 64;

}  // namespace

PixelWindow::Tap::Tap(RegisterSet& registers, const std::string& name, int pixel_bits)
    : word_pixel(registers, "word_pixel" + name, pixel_bits, kNone),
      bypass_pixel(registers, "bypass_pixel" + name, pixel_bits, kNone),
      bypass_word(registers, "bypass_word" + name, kWordBits) {}

PixelWindow::PixelWindow(RegisterSet& registers, std::size_t lines, int addresses, int pixel_bits,
                         const Pins& pins)
    : lines_(lines), addresses_(addresses), pins_(pins) {
    for (std::size_t row = 0; row < lines; ++row) {
        for (std::size_t column = 0; column < lines; ++column) {
            const std::string name =
                lines == 1 ? std::string() : "_" + std::to_string(row) + "_" + std::to_string(column);
            taps_.push_back(std::make_unique<Tap>(registers, name, pixel_bits));
        }
    }
}

/// The pixels that a row's port must give, in the order of the raster.
PixelWindow::Row PixelWindow::row_of(std::size_t row, const RasterStep& step) const {
    if (!step.covered) return {kNone, kNone};
    if (lines_ == 1) return {step.pixel, kNone};
    const BlendWindow<std::int64_t> window = step.window();
    const std::int64_t own = row == 0 ? window.own : window.across;
    const std::int64_t beside = row == 0 ? window.beside : window.diagonal;
    return beside == kNone ? Row{own, kNone} : Row{std::min(own, beside), std::max(own, beside)};
}

/// The word of a pixel, if a register, the FIFO's output or the beat on its way into the FIFO has it.
std::optional<std::uint64_t> PixelWindow::at_hand(std::size_t row, std::size_t column, std::int64_t pixel,
                                                  const SegmentProgress& progress) const {
    const Tap& of = tap(row, column);
    if (of.bypass_pixel == pixel) return of.bypass_word.value();
    if (of.word_pixel == pixel) return pins_.words[row][column]->read();
    const FifoWrite& write = pins_.write.read();
    if (write.count > 0 && progress.has_arrived(pixel)) {
        const int address = buffer_address(progress.base_address, pixel, addresses_);
        const int word = addresses_behind(static_cast<int>(write.address), address, addresses_);
        if (word < write.count) return write.words[static_cast<std::size_t>(word)];
    }
    return std::nullopt;
}

Pixel PixelWindow::pixel_at(std::size_t row, std::size_t column, std::int64_t pixel,
                            const SegmentProgress& progress) const {
    const std::optional<std::uint64_t> word = at_hand(row, column, pixel, progress);
    if (!word) {
        SC_REPORT_ERROR("/metabuffer/merge_stage/pixel",
                        ("pixel " + std::to_string(pixel) + " has come and is not at hand").c_str());
    }
    return Pixel(word.value_or(0));
}

BlendWindow<Pixel> PixelWindow::pixels(const RasterStep& step, const SegmentProgress& progress) const {
    const BlendWindow<std::int64_t> window = step.window();
    const auto pixel = [&](std::size_t row, std::int64_t index) {
        const std::size_t column = row_of(row, step)[0] == index ? 0 : 1;
        return pixel_at(row, column, index, progress);
    };
    const Pixel own = pixel(0, window.own);
    const auto or_own = [&](std::size_t row, std::int64_t index) {
        return index == kNone ? own : pixel(row, index);
    };
    return {own, or_own(0, window.beside), or_own(1, window.across), or_own(1, window.diagonal)};
}

void PixelWindow::clock_edge(const Steps& steps, const SegmentProgress& progress) {
    for (std::size_t row = 0; row < lines_; ++row) {
        const Row next = row_of(row, steps.next);
        const bool reads = reads_[row].enable;
        const Row read = reads ? row_of(row, steps.ahead) : Row{};
        for (std::size_t column = 0; column < lines_; ++column) {
            Tap& of = tap(row, column);
            std::int64_t word_pixel = of.word_pixel;
            if (reads) {
                // Two consecutive words leave the port, whether both are wanted or not.
                word_pixel = read[0] + static_cast<std::int64_t>(column);
                if (!progress.has_arrived(word_pixel)) word_pixel = kNone;
            }
            const std::int64_t wanted = next[column];
            if (wanted != kNone && wanted != word_pixel && of.bypass_pixel != wanted) {
                if (const auto word = at_hand(row, column, wanted, progress)) {
                    of.bypass_pixel = wanted;
                    of.bypass_word = *word;
                }
            }
            of.word_pixel = word_pixel;
        }
    }
}

void PixelWindow::choose_reads(const RasterStep& ahead, const SegmentProgress& progress) {
    for (std::size_t row = 0; row < lines_; ++row) {
        reads_[row] = read_for(row, ahead, progress);
    }
}

FifoRead PixelWindow::read_for(std::size_t row, const RasterStep& ahead,
                               const SegmentProgress& progress) const {
    const Row pixels = row_of(row, ahead);
    if (pixels[0] == kNone) return {};
    FifoRead read;
    read.address = static_cast<std::uint32_t>(buffer_address(progress.base_address, pixels[0], addresses_));
    for (std::size_t column = 0; column < lines_; ++column) {
        const std::int64_t pixel = pixels[column];
        read.enable = read.enable || (pixel != kNone && progress.has_arrived(pixel) && !progress.abandoned &&
                                      !tap(row, column).has(pixel));
    }
    return read;
}

void PixelWindow::forget() {
    for (const auto& each : taps_) {
        each->word_pixel = kNone;
        each->bypass_pixel = kNone;
    }
}

}  // namespace metabuffer::rtl

#include <catch2/catch.hpp>
#include <cstddef>
#include <cstdint>
#include <map>
#include <memory>
#include <string>

#include "dvi_waveform.h"
#include "lockstep/waveform_case.h"
#include "rtl/dvi_decoder.h"
#include "support/rows.h"

namespace metabuffer::test::dvi_decoder_timing_test {
namespace {

using rtl::DecodedPixel;
using rtl::DecoderEvent;
using rtl::DviDecoder;
using rtl::DviLink;

constexpr int kWidth = 18;  // room for two rows
const ViewportTable kTable{table_row(1, {2, 3}, {4, 5}, {-6, -7}, 8), segment_row({9, 10})};
constexpr std::uint32_t kNumber = 11;

/// Pair 11 in a mode of a control scanline and one line, all in one clock of blanking and one of VSYNC: `a` to `r` is
/// the control scanline of the colour frame, `A` to `R` that of the depth frame, `x` a pixel, `v` VSYNC. Events: `c` the
/// colour frame starts, `1` and `2` its rows, `p` and `q` payload, `g` the pair is good.
struct DecoderCase {
    LockstepBench bench;
    WaveformCase<DviDecoder> dut{bench, "dvi_decoder", [](const char* name, rtl::ClockGating) {
                                     return std::make_unique<DviDecoder>(name, DviTiming{kWidth, 2});
                                 }};

    void run(const std::string& link, const std::string& pixels, const std::string& events) {
        std::map<char, DviLink> links{{'x', {0x123456, true, false, false}}, {'v', {0, false, false, true}}};
        const auto colour = control_line(kWidth, FrameKind::kColour, kNumber, kTable);
        const auto depth = control_line(kWidth, FrameKind::kDepth, kNumber, {}, {1, 2, 3, 4, 5});
        for (std::size_t x = 0; x < colour.size(); ++x) {
            links[static_cast<char>('a' + x)] = {colour[x], true, false, false};
            links[static_cast<char>('A' + x)] = {depth[x], true, false, false};
        }
        std::map<char, DecoderEvent> letters;
        letters['c'].colour_start = true;
        letters['c'].number = letters['g'].number = kNumber;
        letters['1'].row = letters['2'].row = true;
        letters['1'].table_row = kTable[0];
        letters['2'].table_row = kTable[1];
        letters['p'].payload_bytes = 3;
        letters['p'].payload = {1, 2, 3};
        letters['q'].payload_bytes = 2;
        letters['q'].payload = {4, 5};
        letters['g'].pair_good = true;
        dut.drive(link, &DviDecoder::link_i, links);
        dut.check(pixels, &DviDecoder::pixel_o, {{'x', {true, FrameKind::kColour, 0, 0x123456}}});
        dut.check(events, &DviDecoder::event_o, letters);
        dut.run();
    }
};

// clang-format off
TEST_CASE("dvi decoder: timing: pixel on the link to pixel at the port of the framebuffer") {
    DecoderCase().run("v.abcdefghijklmnopqr.x..",
                      "......................x?",
                      "????????????????????????");
}
TEST_CASE("dvi decoder: timing: DE low after a control scanline read to its verdict then a row a clock") {
    DecoderCase().run("v.abcdefghijklmnopqr.....",
                      "?????????????????????????",
                      ".....................c12.");
}
TEST_CASE("dvi decoder: timing: payload of a depth frame three bytes a clock on the link to payload at the port of the framebuffer") {
    DecoderCase().run("v.abcdefghijklmnopqr.xxxxxxxxxxxxxxxxxx.v.ABCDEFGHIJKLMNOPQR.",
                      "?????????????????????????????????????????????????????????????",
                      "????????????????????????????????????????????????.pq??????????");
}
TEST_CASE("dvi decoder: timing: VSYNC high after a frame read to the verdict on the frame") {
    DecoderCase().run("v.abcdefghijklmnopqr.xxxxxxxxxxxxxxxxxx.v.ABCDEFGHIJKLMNOPQR.xxxxxxxxxxxxxxxxxx..v..",
                      "????????????????????????????????????????????????????????????????????????????????????",
                      "?????????????????????????????????????????????????????????????????????????.........g.");
}
// clang-format on

}  // namespace
}  // namespace metabuffer::test::dvi_decoder_timing_test

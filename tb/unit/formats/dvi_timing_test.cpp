#include "formats/dvi_timing.h"

#include <catch2/catch.hpp>
#include <cstdint>

namespace metabuffer {
namespace {

TEST_CASE("dvi timing: a line has 80 clocks more than pixels, and a frame 15 lines more than show") {
    const DviTiming timing{100, 50};
    CHECK(timing.line_clocks() == 180);
    CHECK(timing.frame_lines() == 65);
    CHECK(timing.frame_clocks() == 180 * 65);
    CHECK(DviTiming{65535, 65535}.frame_clocks() == std::int64_t{65615} * 65550);
}

TEST_CASE("dvi timing: a renderer's image comes below one control scanline") {
    const DviTiming timing = renderer_dvi_timing(100, 50);
    CHECK(timing.active_pixels == 100);
    CHECK(timing.active_lines == 51);
}

}  // namespace
}  // namespace metabuffer

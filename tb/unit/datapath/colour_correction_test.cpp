#include "datapath/colour_correction.h"

#include <catch2/catch.hpp>
#include <vector>

#include "support/colour_tables.h"

namespace metabuffer::test {
namespace {

TEST_CASE("colour correction: each channel goes through its own table, and the others do not matter") {
    const std::uint64_t seed = random_seed(5);
    INFO("seed " << seed);
    Random random(seed);
    const ColourTable table = random_colour_table(random);
    const auto& [red, green, blue] = table.channels();
    for (std::uint32_t value = 0; value < ColourTable::kValues; ++value) {
        const auto r = static_cast<std::uint8_t>(value);
        const auto g = static_cast<std::uint8_t>(random.bits());
        const auto b = static_cast<std::uint8_t>(255 - value);
        const std::uint32_t colour = corrected(table, (std::uint32_t{r} << 16) | (std::uint32_t{g} << 8) | b);
        CHECK(colour >> 16 == red[r]);
        CHECK(((colour >> 8) & 0xFF) == green[g]);
        CHECK((colour & 0xFF) == blue[b]);
    }
}

TEST_CASE("colour correction: of a span each colour and no other is corrected, whatever its length") {
    Random random(6);
    const ColourTable table = random_colour_table(random);
    for (std::size_t count = 0; count < 40; ++count) {
        std::vector<std::uint32_t> colours(count + 2);
        for (std::uint32_t& colour : colours) colour = static_cast<std::uint32_t>(random.bits()) & 0xFF'FFFF;
        std::vector<std::uint32_t> wanted = colours;
        for (std::size_t n = 1; n <= count; ++n) wanted[n] = corrected(table, colours[n]);
        correct_span(table, colours.data() + 1, count);
        CHECK(colours == wanted);
    }
}

}  // namespace
}  // namespace metabuffer::test

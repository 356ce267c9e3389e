#include "formats/image_difference.h"

#include <catch2/catch.hpp>

namespace metabuffer {
namespace {

TEST_CASE("image difference: none between equal pictures") {
    CHECK_FALSE(image_difference(ColourImage(5, 3, 7), ColourImage(5, 3, 7)));
    CHECK_FALSE(image_difference(ColourImage(), ColourImage()));
}

TEST_CASE("image difference: how many pixels differ, and the first of them row by row with both values") {
    const ColourImage left(5, 3, 0x10);
    ColourImage right = left;
    right.values[5 + 3] = 0x20;  // the second row, of which an earlier column differs only further down
    right.values[10 + 1] = 0x30;
    right.values[10 + 4] = 0x40;  // the last one
    const auto difference = image_difference(left, right);
    REQUIRE(difference);
    CHECK(difference->pixels == 3);
    CHECK(difference->x == 3);
    CHECK(difference->y == 1);
    CHECK(difference->left == 0x10);
    CHECK(difference->right == 0x20);
    right.values[0] = 0;
    const auto from_the_first = image_difference(right, left);
    REQUIRE(from_the_first);
    CHECK(from_the_first->pixels == 4);
    CHECK(from_the_first->x == 0);
    CHECK(from_the_first->y == 0);
    CHECK(from_the_first->left == 0);
    CHECK(from_the_first->right == 0x10);
}

}  // namespace
}  // namespace metabuffer

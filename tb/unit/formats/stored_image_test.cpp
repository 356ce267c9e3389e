#include "formats/stored_image.h"

#include <catch2/catch.hpp>
#include <exception>
#include <stdexcept>
#include <string>

using namespace metabuffer;

TEST_CASE("an image in memory has its pixels from the start", "[formats]") {
    const StoredImage image(PixelImage(3, 2, Pixel(7)));
    CHECK(image.is_read());
    CHECK(image.width_pixels() == 3);
    CHECK(image.height_pixels() == 2);
    CHECK((image.pixels() == PixelImage(3, 2, Pixel(7))));
    CHECK_FALSE(image.failure());
}

TEST_CASE("a stored image is read when its pixels are first needed, and only then", "[formats]") {
    int reads = 0;
    const StoredImage image({3, 2}, [&reads] {
        ++reads;
        return PixelImage(3, 2, Pixel(9));
    });
    CHECK(image.width_pixels() == 3);
    CHECK(image.height_pixels() == 2);
    CHECK_FALSE(image.is_read());
    CHECK(reads == 0);
    const PixelImage& pixels = image.pixels();
    CHECK((pixels == PixelImage(3, 2, Pixel(9))));
    CHECK(&image.pixels() == &pixels);
    CHECK(reads == 1);
    CHECK(image.is_read());
}

TEST_CASE("a stored image keeps the error of its reading, and reads again", "[formats]") {
    int reads = 0;
    const StoredImage image({1, 1}, [&reads] {
        if (++reads == 1) throw std::runtime_error("is broken");
        return PixelImage(1, 1, Pixel(5));
    });
    CHECK_FALSE(image.failure());
    CHECK_THROWS_WITH(image.pixels(), "is broken");
    REQUIRE(image.failure());
    CHECK_THROWS_WITH(std::rethrow_exception(image.failure()), "is broken");
    CHECK_FALSE(image.is_read());
    CHECK(image.pixels().values[0] == Pixel(5));
    CHECK_FALSE(image.failure());
}

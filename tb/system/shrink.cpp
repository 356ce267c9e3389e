#include "shrink.h"

#include <algorithm>
#include <cstdint>
#include <memory>
#include <utility>

#include "host/errors.h"
#include "scenario/names.h"
#include "scenario/scenario_keys.h"
#include "scenario/scenario_loader.h"

namespace metabuffer::test {
namespace {

/// Values to try instead of one that should become smaller: the smallest, half, one less.
std::vector<int> smaller_values(int value, int lowest) {
    std::vector<int> values;
    for (const int candidate : {lowest, lowest + (value - lowest) / 2, value - 1}) {
        const bool is_new = std::find(values.begin(), values.end(), candidate) == values.end();
        if (candidate < value && candidate >= lowest && is_new) values.push_back(candidate);
    }
    return values;
}

/// Collects the legal ones of the steps from one scenario.
class Reducer {
  public:
    explicit Reducer(const Scenario& scenario) : scenario_(scenario) {}

    std::vector<Reduction> all() && {
        renderers();
        displays();
        faults();
        frames();
        lists();
        tables();
        sizes();
        corrections();
        settings();
        rows();
        pictures();
        return std::move(reductions_);
    }

  private:
    template <typename Change>
    void attempt(const std::string& what, Change change) {
        Scenario smaller = scenario_;
        change(smaller);
        try {
            check_scenario(smaller);
        } catch (const InputError&) {
            return;  // not legal
        }
        reductions_.push_back({what, std::move(smaller)});
    }

    void renderers() {
        if (scenario_.renderers.size() < 2) return;
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            attempt("only renderer " + std::to_string(r + 1), [&](Scenario& s) { keep_renderer(s, r); });
        }
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            attempt("without renderer " + std::to_string(r + 1), [&](Scenario& s) { drop_renderer(s, r); });
        }
    }

    static void drop_renderer(Scenario& scenario, std::size_t renderer) {
        const auto gone = static_cast<int>(renderer);
        scenario.renderers.erase(scenario.renderers.begin() + gone);
        auto& faults = scenario.faults;
        faults.erase(std::remove_if(faults.begin(), faults.end(),
                                    [gone](const Fault& fault) { return fault.renderer == gone; }),
                     faults.end());
        for (Fault& fault : faults) fault.renderer -= fault.renderer > gone ? 1 : 0;
    }

    static void keep_renderer(Scenario& scenario, std::size_t renderer) {
        for (std::size_t r = scenario.renderers.size(); r-- > 0;) {
            if (r != renderer) drop_renderer(scenario, r);
        }
    }

    void displays() {
        const DisplayConfig& displays = scenario_.displays;
        if (displays.count() > 1) {
            for (int display = 1; display <= displays.count(); ++display) {
                attempt("only display " + std::to_string(display), [&](Scenario& s) {
                    cut_grid(s, (display - 1) % displays.columns, (display - 1) / displays.columns, 1, 1);
                });
            }
        }
        if (displays.columns > 1) {
            attempt("without the last column of displays",
                    [&](Scenario& s) { cut_grid(s, 0, 0, displays.columns - 1, displays.rows); });
            attempt("without the first column of displays",
                    [&](Scenario& s) { cut_grid(s, 1, 0, displays.columns - 1, displays.rows); });
        }
        if (displays.rows > 1) {
            attempt("without the last row of displays",
                    [&](Scenario& s) { cut_grid(s, 0, 0, displays.columns, displays.rows - 1); });
            attempt("without the first row of displays",
                    [&](Scenario& s) { cut_grid(s, 0, 1, displays.columns, displays.rows - 1); });
        }
    }

    /// Keeps `columns` x `rows` displays of the grid, and what concerns them. Table rows without a display stay.
    static void cut_grid(Scenario& scenario, int first_column, int first_row, int columns, int rows) {
        const int old_columns = scenario.displays.columns;
        const int old_count = scenario.displays.count();
        // The new number of an old display, 0 for one that goes.
        const auto renumbered = [&](int display) {
            const int column = (display - 1) % old_columns - first_column;
            const int row = (display - 1) / old_columns - first_row;
            const bool stays = column >= 0 && column < columns && row >= 0 && row < rows;
            return stays ? row * columns + column + 1 : 0;
        };
        scenario.displays.columns = columns;
        scenario.displays.rows = rows;
        std::vector<DisplayCorrection> corrections;
        for (DisplayCorrection correction : scenario.displays.correction) {
            correction.display = renumbered(correction.display);
            if (correction.display != 0) corrections.push_back(std::move(correction));
        }
        scenario.displays.correction = std::move(corrections);
        for (Renderer& renderer : scenario.renderers) {
            for (RendererFrame& frame : renderer.frames) {
                ViewportTable table;
                for (ViewportRow row : frame.table) {
                    if (row.dcomp >= 1 && row.dcomp <= old_count) {
                        const int display = renumbered(row.dcomp);
                        if (display == 0) continue;
                        row.dcomp = static_cast<std::uint16_t>(display);
                    }
                    table.push_back(row);
                }
                set_table(frame, std::move(table));
            }
        }
        std::vector<Fault> faults;
        for (Fault fault : scenario.faults) {
            if (fault.display > 0) {
                fault.display = renumbered(fault.display);
                if (fault.display == 0) continue;
            }
            faults.push_back(fault);
        }
        scenario.faults = std::move(faults);
    }

    /// The table counts. A viewport whose split is another table would make another scenario when written.
    static void set_table(RendererFrame& frame, ViewportTable table) {
        frame.table = std::move(table);
        frame.viewport.reset();
    }

    void faults() {
        if (scenario_.faults.size() > 1) {
            attempt("without faults", [](Scenario& s) { s.faults.clear(); });
        }
        for (std::size_t i = 0; i < scenario_.faults.size(); ++i) {
            attempt("without fault " + std::to_string(i),
                    [i](Scenario& s) { s.faults.erase(s.faults.begin() + static_cast<std::ptrdiff_t>(i)); });
        }
        for (std::size_t i = 0; i < scenario_.faults.size(); ++i) {
            const Fault& fault = scenario_.faults[i];
            if (fault.pair > 0) {
                attempt("fault " + std::to_string(i) + " a pair earlier",
                        [i](Scenario& s) { --s.faults[i].pair; });
            }
            const std::string name = "fault " + std::to_string(i);
            if (fault.lines > 1) attempt(name + " of one line", [i](Scenario& s) { s.faults[i].lines = 1; });
            if (fault.beats > 1) attempt(name + " of one beat", [i](Scenario& s) { s.faults[i].beats = 1; });
            if (fault.of == LostBeats::kAny) {
                for (const LostBeats of : {LostBeats::kPixels, LostBeats::kTable}) {
                    attempt(name + " of " + to_string(of) + " only",
                            [i, of](Scenario& s) { s.faults[i].of = of; });
                }
            }
            if (fault.cycles.value_or(1) > 1) {
                attempt(name + " half as long",
                        [i](Scenario& s) { s.faults[i].cycles = *s.faults[i].cycles / 2; });
            }
            if (fault.from_cycle > 0) {
                attempt(name + " from clock 0", [i](Scenario& s) { s.faults[i].from_cycle = 0; });
            }
            if (fault.delay_pairs > 1) {
                attempt("fault " + std::to_string(i) + " delays a pair time less",
                        [i](Scenario& s) { --s.faults[i].delay_pairs; });
            }
        }
    }

    void frames() {
        for (const int frames : smaller_values(scenario_.frames, 1)) {
            attempt(std::to_string(frames) + " frames", [frames](Scenario& s) { s.frames = frames; });
        }
    }

    /// Entries of the renderers' lists, and images that none names.
    void lists() {
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const std::string name = "renderer " + std::to_string(r + 1) + ": ";
            const std::size_t entries = scenario_.renderers[r].frames.size();
            if (entries < 2) continue;
            attempt(name + "the last entry of its list alone", [r](Scenario& s) {
                auto& frames = s.renderers[r].frames;
                frames.erase(frames.begin(), frames.end() - 1);
            });
            for (std::size_t entry = entries; entry-- > 0;) {
                attempt(name + "without entry " + std::to_string(entry), [r, entry](Scenario& s) {
                    auto& frames = s.renderers[r].frames;
                    frames.erase(frames.begin() + static_cast<std::ptrdiff_t>(entry));
                });
            }
        }
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            if (scenario_.renderers[r].images.size() < 2) continue;
            attempt("renderer " + std::to_string(r + 1) + ": one image", [r](Scenario& s) {
                s.renderers[r].images.resize(1);
                for (RendererFrame& frame : s.renderers[r].frames) frame.image = 0;
            });
        }
    }

    template <typename Change>
    void for_each_table(Change change) {
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            for (std::size_t f = 0; f < scenario_.renderers[r].frames.size(); ++f) {
                const std::string name =
                    "renderer " + std::to_string(r + 1) + ", entry " + std::to_string(f) + ": ";
                change(r, f, name, scenario_.renderers[r].frames[f].table);
            }
        }
    }

    void tables() {
        for_each_table([this](std::size_t r, std::size_t f, const std::string& name,
                              const ViewportTable& table) {
            if (scenario_.renderers[r].frames[f].slots) {
                attempt(name + "slots computed",
                        [r, f](Scenario& s) { s.renderers[r].frames[f].slots.reset(); });
            }
            if (table.size() > 1) {
                attempt(name + "no row", [r, f](Scenario& s) { set_table(s.renderers[r].frames[f], {}); });
            }
            for (std::size_t i = table.size(); i-- > 0;) {
                attempt(name + "without row " + std::to_string(i), [&](Scenario& s) {
                    ViewportTable shorter = table;
                    shorter.erase(shorter.begin() + static_cast<std::ptrdiff_t>(i));
                    set_table(s.renderers[r].frames[f], shorter);
                });
            }
        });
    }

    void sizes() {
        const DisplayConfig& displays = scenario_.displays;
        if (displays.supersample > 1) {
            attempt("no supersampling", [](Scenario& s) { s.displays.supersample = 1; });
        }
        for (const int width : smaller_values(displays.width_pixels, 1)) {
            attempt("displays " + std::to_string(width) + " wide", [width](Scenario& s) {
                s.displays.width_pixels = width;
                leave_viewports(s);
            });
        }
        for (const int height : smaller_values(displays.height_pixels, 1)) {
            attempt("displays " + std::to_string(height) + " high", [height](Scenario& s) {
                s.displays.height_pixels = height;
                leave_viewports(s);
            });
        }
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            const Renderer& renderer = scenario_.renderers[r];
            const std::string name = "renderer " + std::to_string(r + 1) + ": images ";
            for (const int width : smaller_values(renderer.image_width_pixels, 1)) {
                attempt(name + std::to_string(width) + " wide",
                        [&](Scenario& s) { crop(s.renderers[r], width, renderer.image_height_pixels); });
            }
            for (const int height : smaller_values(renderer.image_height_pixels, 1)) {
                attempt(name + std::to_string(height) + " high",
                        [&](Scenario& s) { crop(s.renderers[r], renderer.image_width_pixels, height); });
            }
        }
    }

    static void leave_viewports(Scenario& scenario) {
        for (Renderer& renderer : scenario.renderers) {
            for (RendererFrame& frame : renderer.frames) frame.viewport.reset();
        }
    }

    /// Cuts the images, and the source rectangles that lie within them along with these.
    static void crop(Renderer& renderer, int width, int height) {
        for (auto& image : renderer.images) {
            PixelImage smaller(width, height);
            for (int y = 0; y < height; ++y) {
                for (int x = 0; x < width; ++x) smaller.at(x, y) = image->pixels().at(x, y);
            }
            image = std::make_shared<const StoredImage>(std::move(smaller));
        }
        for (RendererFrame& frame : renderer.frames) {
            frame.viewport.reset();
            for (ViewportRow& row : frame.table) {
                if (row.sx + row.sdx <= renderer.image_width_pixels) cut_to(row.sx, row.sdx, width);
                if (row.sy + row.sdy <= renderer.image_height_pixels) cut_to(row.sy, row.sdy, height);
            }
        }
        renderer.image_width_pixels = width;
        renderer.image_height_pixels = height;
    }

    static void cut_to(std::uint16_t& start, std::uint16_t& count, int extent) {
        count = static_cast<std::uint16_t>(std::min<int>(count, extent));
        start = static_cast<std::uint16_t>(std::min<int>(start, extent - count));
    }

    void corrections() {
        const std::vector<DisplayCorrection>& all = scenario_.displays.correction;
        if (all.size() > 1) {
            attempt("no display corrected", [](Scenario& s) { s.displays.correction.clear(); });
        }
        for (std::size_t i = 0; i < all.size(); ++i) {
            attempt("display " + std::to_string(all[i].display) + " not corrected", [i](Scenario& s) {
                s.displays.correction.erase(s.displays.correction.begin() + static_cast<std::ptrdiff_t>(i));
            });
        }
    }

    /// Each setting at its default, if it is not there yet and has one. The grid, the frames and the depth format have
    /// their own steps, since more depends on them. A name does not make a machine smaller.
    void settings() {
        for (const ObjectKey<Scenario>& key : setting_rows()) {
            const std::string path = key.schema.pattern;
            const bool has_own_steps = path.rfind("displays.", 0) == 0 && path != "displays.background";
            if (key.value == nullptr || has_own_steps || path == "name" || path == "frames" ||
                path == "depth_format" || path == "depth_range") {
                continue;
            }
            const std::optional<KeyValue> usual = key.value(Scenario());
            if (!usual || key.value(scenario_) == usual) continue;
            attempt(path + " as by default", [&](Scenario& s) { key.set(s, *usual); });
        }
        if (scenario_.depth_format != DepthFormat::kA8Z16) {
            attempt("depth_format as by default", [](Scenario& s) {
                s.depth_format = DepthFormat::kA8Z16;
                for (Renderer& renderer : s.renderers) clip_depths(renderer);
            });
        }
    }

    static void clip_depths(Renderer& renderer) {
        for (auto& image : renderer.images) {
            PixelImage clipped = image->pixels();
            for (Pixel& pixel : clipped.values) {
                pixel =
                    Pixel(pixel.r(), pixel.g(), pixel.b(), pixel.a(), pixel.z() & far_z(DepthFormat::kA8Z16));
            }
            image = std::make_shared<const StoredImage>(std::move(clipped));
        }
    }

    template <typename Field>
    void field(std::size_t r, std::size_t f, std::size_t row, const std::string& name,
               Field ViewportRow::*member, int value) {
        attempt(name + std::to_string(value), [=](Scenario& s) {
            RendererFrame& frame = s.renderers[r].frames[f];
            frame.table[row].*member = static_cast<Field>(value);
            frame.viewport.reset();
        });
    }

    void rows() {
        for_each_table(
            [this](std::size_t r, std::size_t f, const std::string& name, const ViewportTable& table) {
                for (std::size_t i = 0; i < table.size(); ++i) {
                    const ViewportRow& row = table[i];
                    const std::string where = name + "row " + std::to_string(i) + ", ";
                    for (const int m : smaller_values(row.dmultiple, 1)) {
                        field(r, f, i, where + "Dmultiple ", &ViewportRow::dmultiple, m);
                    }
                    for (const int count : smaller_values(row.sdx, 1))
                        field(r, f, i, where + "Sdx ", &ViewportRow::sdx, count);
                    for (const int count : smaller_values(row.sdy, 1))
                        field(r, f, i, where + "Sdy ", &ViewportRow::sdy, count);
                    if (row.dx != 0) field(r, f, i, where + "Dx ", &ViewportRow::dx, 0);
                    if (row.dy != 0) field(r, f, i, where + "Dy ", &ViewportRow::dy, 0);
                    if (row.sx != 0) field(r, f, i, where + "Sx ", &ViewportRow::sx, 0);
                    if (row.sy != 0) field(r, f, i, where + "Sy ", &ViewportRow::sy, 0);
                }
            });
    }

    /// Images of one colour and depth.
    void pictures() {
        for (std::size_t r = 0; r < scenario_.renderers.size(); ++r) {
            for (std::size_t i = 0; i < scenario_.renderers[r].images.size(); ++i) {
                const PixelImage& image = scenario_.renderers[r].images[i]->pixels();
                const Pixel pixel = image.values.front();
                if (std::all_of(image.values.begin(), image.values.end(),
                                [pixel](const Pixel& other) { return other == pixel; })) {
                    continue;
                }
                attempt("renderer " + std::to_string(r + 1) + ": image " + std::to_string(i) +
                            " of one pixel's kind",
                        [&](Scenario& s) {
                            PixelImage plain(image.width_pixels, image.height_pixels);
                            std::fill(plain.values.begin(), plain.values.end(), pixel);
                            s.renderers[r].images[i] = std::make_shared<const StoredImage>(std::move(plain));
                        });
            }
        }
    }

    const Scenario& scenario_;
    std::vector<Reduction> reductions_;
};

}  // namespace

std::vector<Reduction> reductions(const Scenario& scenario) { return Reducer(scenario).all(); }

Shrunk shrink(const Scenario& scenario, const StillFails& still_fails, int most_runs) {
    Shrunk result;
    result.scenario = scenario;
    std::vector<Reduction> steps = reductions(scenario);
    std::size_t next = 0;
    std::size_t failed_in_a_row = 0;
    while (failed_in_a_row < steps.size()) {
        if (result.runs == most_runs) return result;
        next %= steps.size();
        ++result.runs;
        if (!still_fails(steps[next].scenario)) {
            ++next;
            ++failed_in_a_row;
            continue;
        }
        result.steps.push_back(steps[next].what);
        result.scenario = std::move(steps[next].scenario);
        steps = reductions(result.scenario);
        // A step that did not help before seldom helps now: go on after the step that did, and come back to it later.
        failed_in_a_row = 0;
    }
    result.at_its_smallest = true;
    return result;
}

}  // namespace metabuffer::test

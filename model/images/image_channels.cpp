#include "images/image_channels.h"

#include <algorithm>
#include <array>
#include <cstddef>

#include "host/errors.h"
#include "host/text.h"

namespace metabuffer::image_channels {
namespace {

using Parts = std::vector<Part>;

/// Channels of a part whose names differ behind the last dot alone.
struct Layer {
    int part = 0;
    std::string part_name;             ///< empty if the file has one part
    std::string prefix;                ///< "diffuse" of "diffuse.R"; empty for a channel without a dot
    std::vector<std::string> names{};  ///< "R"
    std::vector<int> channels{};       ///< of the part

    int channel(const std::string& name) const {
        const auto found = std::find(names.begin(), names.end(), name);
        return found == names.end() ? kNoChannel : channels[static_cast<std::size_t>(found - names.begin())];
    }
    bool has(const std::string& name) const { return channel(name) != kNoChannel; }

    /// As keys of scenarios name it; empty if it has no name.
    std::string name() const {
        if (prefix.empty() || prefix == part_name) return part_name;
        return part_name.empty() ? prefix : part_name + "." + prefix;
    }
    bool is_called(const std::string& wanted) const {
        return wanted == name() || wanted == part_name || wanted == prefix;
    }
    std::string name_of(std::size_t n) const { return name().empty() ? names[n] : name() + "." + names[n]; }
};

std::vector<Layer> layers_of(const Parts& parts) {
    std::vector<Layer> layers;
    for (std::size_t part = 0; part < parts.size(); ++part) {
        const std::size_t first = layers.size();
        const std::vector<std::string>& channels = parts[part].channels;
        for (std::size_t channel = 0; channel < channels.size(); ++channel) {
            const std::string& full = channels[channel];
            const std::size_t dot = full.rfind('.');
            const std::string prefix = dot == std::string::npos ? "" : full.substr(0, dot);
            auto layer = std::find_if(layers.begin() + static_cast<std::ptrdiff_t>(first), layers.end(),
                                      [&prefix](const Layer& other) { return other.prefix == prefix; });
            if (layer == layers.end()) {
                const std::string part_name = parts.size() > 1 ? parts[part].name : "";
                layers.push_back({static_cast<int>(part), part_name, prefix});
                layer = std::prev(layers.end());
            }
            layer->names.push_back(dot == std::string::npos ? full : full.substr(dot + 1));
            layer->channels.push_back(static_cast<int>(channel));
        }
    }
    return layers;
}

std::string channel_list(const std::vector<Layer>& layers) {
    constexpr std::size_t kMostNames = 24;
    std::vector<std::string> names;
    for (const Layer& layer : layers) {
        for (std::size_t n = 0; n < layer.names.size(); ++n) names.push_back(layer.name_of(n));
    }
    if (names.size() > kMostNames) {
        const std::size_t more = names.size() - kMostNames;
        names.resize(kMostNames);
        names.push_back(std::to_string(more) + " more");
    }
    return text::joined(names, "and");
}

std::optional<Colours> colours_in(const Layer& layer) {
    struct Names {
        const char* red;
        const char* green;
        const char* blue;
        const char* alpha;
    };
    constexpr std::array<Names, 2> kColours{{{"R", "G", "B", "A"}, {"r", "g", "b", "a"}}};
    for (const Names& names : kColours) {
        if (!layer.has(names.red) || !layer.has(names.green) || !layer.has(names.blue)) continue;
        return Colours{layer.part, layer.channel(names.red), layer.channel(names.green),
                       layer.channel(names.blue), layer.channel(names.alpha)};
    }
    return std::nullopt;
}

/// Not the luminance of an image whose colours are in RY and BY.
std::optional<Colours> grey_in(const Layer& layer) {
    const int grey = layer.channel("Y");
    if (grey == kNoChannel || layer.has("RY") || layer.has("BY") || layer.has("X")) return std::nullopt;
    return Colours{layer.part, grey, grey, grey, layer.channel("A")};
}

/// A layer's channel of Z.
struct DepthChannel {
    const Layer* layer = nullptr;
    std::size_t index = 0;  ///< into its names

    std::string full_name() const { return layer->name_of(index); }
    Depth depth() const { return {layer->part, layer->channels[index]}; }
    /// Whether a name says that it is depth, not only that it is Z of something.
    bool is_named_for_depth() const {
        const auto says_so = [](const std::string& name) {
            const std::string last = name.substr(name.rfind('.') + 1);  // all of it if there is no dot
            return last == "Depth" || last == "depth";
        };
        return says_so(layer->names[index]) || says_so(layer->prefix) || says_so(layer->part_name);
    }
};

std::vector<DepthChannel> depth_channels(const std::vector<Layer>& layers) {
    std::vector<DepthChannel> found;
    for (const Layer& layer : layers) {
        for (std::size_t n = 0; n < layer.names.size(); ++n) {
            const std::string& name = layer.names[n];
            const bool is_depth =
                name == "Depth" || name == "depth" || (name == "Z" && !layer.has("X") && !layer.has("Y"));
            if (is_depth) found.push_back({&layer, n});
        }
    }
    return found;
}

template <typename Item, typename Name>
[[noreturn]] void fail_for_choice(const char* what, const std::vector<Item>& items, Name name_of,
                                  const char* key) {
    std::vector<std::string> names;
    names.reserve(items.size());
    for (const Item& item : items) names.push_back(name_of(item));
    throw InputError(std::string("has several ") + what + ", " + text::joined(names, "and") + "; use " + key +
                     ", one of them");
}

template <typename Test>
std::vector<Layer> layers_that(const std::vector<Layer>& layers, Test test) {
    std::vector<Layer> chosen;
    std::copy_if(layers.begin(), layers.end(), std::back_inserter(chosen), test);
    return chosen;
}

/// Of layers with colours, in the order in which they are preferred.
std::optional<Colours> only_colours(const std::vector<Layer>& layers, const char* key) {
    using Test = bool (*)(const Layer&);
    constexpr std::array<Test, 3> kPreferred{
        [](const Layer& layer) { return layer.prefix.empty() && colours_in(layer).has_value(); },
        [](const Layer& layer) { return colours_in(layer).has_value(); },
        [](const Layer& layer) { return grey_in(layer).has_value(); }};
    for (const Test test : kPreferred) {
        const std::vector<Layer> chosen = layers_that(layers, test);
        if (chosen.size() > 1) {
            fail_for_choice(
                "layers of colours", chosen,
                [](const Layer& layer) { return layer.name().empty() ? "one without a name" : layer.name(); },
                key);
        }
        if (!chosen.empty()) {
            const std::optional<Colours> colours = colours_in(chosen.front());
            return colours ? colours : grey_in(chosen.front());
        }
    }
    return std::nullopt;
}

/// The only one that fits, the only one that is named for depth, or none.
std::optional<Depth> only_depth(const std::vector<DepthChannel>& channels) {
    std::vector<DepthChannel> named;
    std::copy_if(channels.begin(), channels.end(), std::back_inserter(named),
                 [](const DepthChannel& channel) { return channel.is_named_for_depth(); });
    if (channels.size() > 1 && named.size() != 1) {
        fail_for_choice(
            "channels of Z", channels, [](const DepthChannel& channel) { return channel.full_name(); },
            "depth_layer");
    }
    if (channels.empty()) return std::nullopt;
    return (channels.size() == 1 ? channels : named).front().depth();
}

/// Z in the layer of that name, or in the channel of that name. colours_are_depth: R, G and B may be Z.
Depth depth_of(const std::vector<Layer>& layers, const std::string& wanted, bool colours_are_depth) {
    for (const Layer& layer : layers) {
        for (std::size_t n = 0; n < layer.names.size(); ++n) {
            if (layer.name_of(n) == wanted) return {layer.part, layer.channels[n]};
        }
    }
    const std::vector<Layer> called =
        layers_that(layers, [&wanted](const Layer& layer) { return layer.is_called(wanted); });
    if (const std::optional<Depth> depth = only_depth(depth_channels(called))) return *depth;
    if (called.size() == 1 && called.front().channels.size() == 1) {
        return {called.front().part, called.front().channels.front()};
    }
    if (colours_are_depth && called.size() == 1) {
        if (const auto colours = colours_in(called.front())) return {colours->part, colours->red, colours};
    }
    throw InputError("has the channels " + channel_list(layers) + " and no Z in a layer " +
                     text::quoted(wanted) + "; use depth_layer, a layer or a channel of Z");
}

}  // namespace

Colours find_colours(const Parts& parts, const std::optional<std::string>& layer) {
    const std::vector<Layer> layers = layers_of(parts);
    const std::vector<Layer> called =
        layers_that(layers, [&layer](const Layer& one) { return !layer || one.is_called(*layer); });
    if (const std::optional<Colours> colours = only_colours(called, "layer")) return *colours;
    if (!layer) {
        throw InputError("has the channels " + channel_list(layers) +
                         "; use R, G and B, or Y, and A and Z if need be");
    }
    throw InputError("has the channels " + channel_list(layers) + " and no colours in a layer " +
                     text::quoted(*layer) + "; use layer, a layer with R, G and B");
}

Depth find_depth(const Parts& parts, const std::optional<std::string>& layer, const Colours& colours) {
    const std::vector<Layer> layers = layers_of(parts);
    if (layer) return depth_of(layers, *layer, false);
    const std::vector<DepthChannel> channels = depth_channels(layers);
    for (const DepthChannel& channel : channels) {
        const std::vector<int>& of_layer = channel.layer->channels;
        const bool is_with_colours =
            channel.layer->part == colours.part &&
            std::find(of_layer.begin(), of_layer.end(), colours.red) != of_layer.end();
        if (is_with_colours && channel.layer->names[channel.index] == "Z") return channel.depth();
    }
    if (const std::optional<Depth> depth = only_depth(channels)) return *depth;
    // Without Z it would be the nearest of all and hide every other image.
    throw InputError("has the channels " + channel_list(layers) +
                     " and no Z; use depth, a file of Z, z, one depth for all of it, or depth_layer, a layer "
                     "or a channel of the file");
}

Depth find_depth_alone(const Parts& parts, const std::optional<std::string>& layer) {
    const std::vector<Layer> layers = layers_of(parts);
    if (layer) return depth_of(layers, *layer, true);
    if (const std::optional<Depth> depth = only_depth(depth_channels(layers))) return *depth;
    if (layers.size() == 1 && layers.front().channels.size() == 1) {
        return {layers.front().part, layers.front().channels.front()};
    }
    if (const std::optional<Colours> colours = only_colours(layers, "depth_layer")) {
        if (colours->red == colours->green) return {colours->part, colours->red};
        return {colours->part, colours->red, colours};
    }
    throw InputError("has the channels " + channel_list(layers) +
                     "; use one channel, one of several that is called Z, or depth_layer");
}

}  // namespace metabuffer::image_channels

#include "render/view.h"

namespace wry::render {

std::vector<View> standard_views() {
  return {
      {.name = "beauty", .heat = {}},
      {.name = "clay", .colouring = Colouring::clay, .heat = {}},
      {.name = "wire", .colouring = Colouring::clay, .wire = Wire::overlay, .heat = {}},
      {.name = "directors", .signs = Signs::directors, .heat = {}},
      {.name = "fibres", .signs = Signs::fibres, .heat = {}},
      {.name = "contacts", .signs = Signs::contacts, .heat = {}},
  };
}

View heat_view(const HeatStyle& style) {
  View view;
  view.name = "heat-" + style.channel;
  view.colouring = Colouring::heat;
  view.tone = Tone::plain;
  view.heat = style;
  return view;
}

} // namespace wry::render

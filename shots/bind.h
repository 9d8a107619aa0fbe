#pragma once

#include "shots/diagnostics.h"
#include "shots/reader.h"
#include "shots/schema.h"

namespace wry::shots {

/// The checked tree as a Shot. `log`, when given, collects the keys that were read.
Shot bind_shot(const Table& checked, const std::string& file, const std::string& directory, ReadLog* log = nullptr);

Collider bind_collider(const Reader& reader, const std::string& directory, Axis up);
Body bind_body(const Reader& reader, const std::string& directory);
/// size, scale, units, up, rotate, translate.
void bind_placement(const Reader& reader, Placed& placed);
/// keys, pivot, ease; a key that leaves something out has it from the key before. `up` is the first axis.
Motion bind_motion(const Reader& reader, Axis up);
/// A file, relative to the folder of the shot.
Located<std::string> bind_path(const Reader& reader, const std::string& key, const std::string& directory);
Material bind_material(const Reader& reader, const std::string& name);
/// The keys of the material point method.
Matter bind_matter(const Reader& reader);
ParticleBody bind_particles(const Reader& reader, const std::string& directory);
MpmOptions bind_mpm(const Reader& reader);
RenderOptions bind_render(const Reader& reader);
Drive bind_drive(const Reader& reader, Axis up);
Load bind_load(const Reader& reader);
/// { x = ..., y = ..., z = ... } of formulas.
std::array<std::optional<Located<Expression>>, 3> bind_components(const Reader& reader);
Region bind_region(const Reader& reader);
Axis axis_of(const std::string& word);

/// What no single key can tell: keys that need each other, or exclude each other by value.
void check_rules(const Shot& shot, Diagnostics& diagnostics);

} // namespace wry::shots

#pragma once

/// The names of what matter does, for shots and kernels alike: no standard library.
namespace wry::mpm {

enum class Elasticity { linear, hencky, fixed_corotated };
enum class Plasticity { none, snow, drucker_prager, shear };
/// How the material frame is carried (spec S4.3, S7); automatic: polar without plasticity, else shape.
/// How the axes of a material turn: with its elastic deformation, with its neighbourhood, or not at all.
enum class FrameMode { automatic, polar, shape, fixed };
/// What a law calls strain: ln V (Hencky) or V - I (Biot). fixed_corotated may use either; automatic: linear is Biot,
/// the others Hencky.
enum class StrainMeasure { automatic, hencky, biot };
/// Direction of Drucker-Prager's flow (spec S5, "Volume").
enum class Flow { fictitious, isochoric };

} // namespace wry::mpm

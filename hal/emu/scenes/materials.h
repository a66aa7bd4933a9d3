#pragma once

#include "hal/emu/scenes/scene.h"

// Materials of corridors, doors and people.
namespace stof::hal::emu::material {

// Dyes absorb little infrared: cloth and paint differ less for the PMD camera than for the eye.
inline constexpr Material kWhite{.albedo = 0.8, .nir = 0.85};
inline constexpr Material kPaint{.albedo = 0.75, .nir = 0.85, .gloss = 0.06, .gloss_log2 = 6};
inline constexpr Material kSkirting{.albedo = 0.3,
                                    .contrast = 0.25,
                                    .texture = Texture::kNoise,
                                    .period_m = 0.3,
                                    .seed = 11,
                                    .nir = 0.4};
inline constexpr Material kFrame{.albedo = 0.5, .nir = 0.55};
inline constexpr Material kDoor{.albedo = 0.42,
                                .contrast = 0.5,
                                .texture = Texture::kNoise,
                                .period_m = 0.15,
                                .seed = 21,
                                .nir = 0.5,
                                .gloss = 0.05,
                                .gloss_log2 = 7};
inline constexpr Material kFloor{.albedo = 0.5,
                                 .contrast = 0.55,
                                 .texture = Texture::kNoise,
                                 .period_m = 0.05,
                                 .seed = 31,
                                 .nir = 0.5,
                                 .gloss = 0.05,
                                 .gloss_log2 = 6};
inline constexpr Material kPicture{.albedo = 0.75,
                                   .contrast = 0.95,
                                   .texture = Texture::kNoise,
                                   .period_m = 0.16,
                                   .seed = 41,
                                   .nir = 0.55,
                                   .gloss = 0.05,
                                   .gloss_log2 = 8};
inline constexpr Material kBlack{.albedo = 0.07, .nir = 0.3};
inline constexpr Material kShirt{
    .albedo = 0.72, .contrast = 0.8, .texture = Texture::kChecks, .period_m = 0.07, .nir = 0.6};
inline constexpr Material kTrousers{.albedo = 0.2,
                                    .contrast = 0.4,
                                    .texture = Texture::kNoise,
                                    .period_m = 0.06,
                                    .seed = 51,
                                    .nir = 0.45};
inline constexpr Material kSkin{.albedo = 0.55, .nir = 0.6};
inline constexpr Material kHair{.albedo = 0.14,
                                .contrast = 0.7,
                                .texture = Texture::kNoise,
                                .period_m = 0.03,
                                .seed = 61,
                                .nir = 0.35};
inline constexpr Material kCarton{.albedo = 0.45,
                                  .contrast = 0.25,
                                  .texture = Texture::kNoise,
                                  .period_m = 0.12,
                                  .seed = 71,
                                  .nir = 0.55};
inline constexpr Material kTape{.albedo = 0.65, .nir = 0.6};
inline constexpr Material kRed{.albedo = 0.2, .nir = 0.5, .gloss = 0.04, .gloss_log2 = 6};

}  // namespace stof::hal::emu::material

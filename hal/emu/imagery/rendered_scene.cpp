#include "hal/emu/imagery/rendered_scene.h"

namespace stof::hal::emu {

RenderedScene::RenderedScene(const Scene& scene, const Rig& rig)
    : sensors_(rig),
      views_(sensors_.render(scene)),
      depth_(sensors_.depth(scene)),
      visible_(sensors_.visible(scene)) {}

void RenderedScene::left(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors_.left(views_, number, out);
}

void RenderedScene::right(std::uint32_t number, dsp::ImageView<std::uint8_t> out) noexcept {
  sensors_.right(views_, number, out);
}

void RenderedScene::pmd(std::uint32_t number, int index,
                        dsp::ImageView<std::uint16_t> out) noexcept {
  sensors_.pmd(views_, number, index, out);
}

}  // namespace stof::hal::emu

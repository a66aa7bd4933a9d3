# The emulated sensor: docker build -t stof . && docker run --rm --network host stof [flags of stofd]
FROM debian:bookworm AS build
WORKDIR /stof
COPY . .
RUN scripts/setup run && cmake --preset emu -Wno-dev -DSTOF_TESTS=OFF && cmake --build build/emu --target stofd stof

FROM debian:bookworm-slim
RUN apt-get update && apt-get install -y --no-install-recommends libceres3 libpng16-16 libzstd1 && rm -rf /var/lib/apt/lists/* && useradd stof
COPY --from=build /stof/build/emu/bin/stofd /stof/build/emu/bin/stof /usr/local/bin/
USER stof
EXPOSE 7560/udp
ENTRYPOINT ["stofd"]

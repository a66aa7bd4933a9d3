# The emulated sensor: docker build -t stof . && docker run --rm --network host stof [flags of stofd]
FROM debian:bookworm AS build
WORKDIR /stof
COPY . .
RUN scripts/setup run && cmake --preset package -Wno-dev && cmake --build build/package --target stofd stof

FROM debian:bookworm-slim
# What stof is linked with, as the package stof-tools has it.
RUN apt-get update && apt-get install -y --no-install-recommends libcholmod3 libcxsparse3 libgoogle-glog0v6 liblapack3 libpng16-16 libspqr2 libstdc++6 libzstd1 \
  && rm -rf /var/lib/apt/lists/* && useradd stof
COPY --from=build /stof/build/package/bin/stofd /stof/build/package/bin/stof /usr/local/bin/
USER stof
EXPOSE 7560/udp
ENTRYPOINT ["stofd"]

# The emulated sensor: docker build -t stof . && docker run --rm --network host stof [flags of stofd]
FROM debian:bookworm AS build
WORKDIR /stof
COPY . .
RUN scripts/setup package
RUN scripts/package --out /packages

FROM debian:bookworm-slim
COPY --from=build /packages/ /packages/
COPY scripts/packaging/container.sh /usr/local/bin/stof-container
# By the packages, which know what they need; no init.
RUN apt-get update && apt-get install -y --no-install-recommends systemd-standalone-sysusers /packages/*.deb && rm -rf /packages /var/lib/apt/lists/*
USER stof
EXPOSE 7560/udp
ENTRYPOINT ["stof-container"]

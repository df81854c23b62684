// The three-dimensional view as a component: it receives design and state, and draws them (squama-view, scene.js).
import { BeamScene, geometry } from "squama-view";
import { toRaw } from "vue";

export default {
  props: { design: Object, state: Object, words: String, arrows: Boolean, palette: Object },
  emits: ["dark", "rest"],
  template: `
    <div class="view">
      <canvas tabindex="0" role="img" :aria-label="words + '. Arrow keys turn, plus and minus zoom, Home resets.'"
        @keydown="key"></canvas>
      <p class="lost" v-if="lost" role="alert">This browser shows no WebGL, which the view needs.</p>
    </div>`,
  data: () => ({ lost: false }),
  mounted() {
    const canvas = this.$el.querySelector("canvas");
    try {
      this.beam = new BeamScene(canvas, this.palette);
    } catch {
      this.lost = true;
      return;
    }
    // for tests and for people with a console
    Object.assign(window, { squamaView: this.beam, squamaGeometry: geometry });
    this.watched = new ResizeObserver(() => this.beam.resize(this.$el.clientWidth, this.$el.clientHeight));
    this.watched.observe(this.$el);
    this.themed = new MutationObserver(() => this.theme());
    this.themed.observe(document.body, { attributes: true, attributeFilter: ["class"] });
    this.beam.resize(this.$el.clientWidth, this.$el.clientHeight);
    this.show();
    this.theme();
  },
  beforeUnmount() {
    cancelAnimationFrame(this.playing);
    this.watched?.disconnect();
    this.themed?.disconnect();
    this.beam?.dispose();
  },
  watch: {
    state: "show",
    design: "show",
    arrows: "show",
  },
  methods: {
    show() {
      if (!this.beam) return;
      cancelAnimationFrame(this.playing);
      this.beam.arrows = this.arrows;
      // read without Vue's proxies, number by number
      this.beam.set(toRaw(this.design), toRaw(this.state));
    },
    // pictures {design, state}, step ms apart; then the state of the page again
    play(frames, step) {
      if (!this.beam) return;
      this.beam.film(frames);
      const began = performance.now();
      const next = (now) => {
        const frame = frames[Math.max(0, Math.floor((now - began) / step))];
        if (!frame) return this.rest();
        this.beam.set(frame.design, frame.state);
        this.playing = requestAnimationFrame(next);
      };
      cancelAnimationFrame(this.playing);
      this.playing = requestAnimationFrame(next);
    },
    rest() {
      this.show();
      this.$emit("rest");
    },
    theme() {
      const dark = document.body.classList.contains("body--dark");
      if (dark === this.dark) return;
      this.dark = dark;
      this.beam.theme(dark ? "dark" : "light");
      this.$emit("dark", dark);
    },
    key(event) {
      if (this.beam?.key(event.key)) event.preventDefault();
    },
    reset() {
      this.beam?.reset();
    },
    save(name, width, height) {
      if (!this.beam) return;
      const link = document.createElement("a");
      link.href = this.beam.picture(width, height);
      link.download = name;
      link.click();
    },
  },
};
